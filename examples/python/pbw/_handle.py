"""A live triangulation of the library's.

In: arrays that were checked.  Out: Meshes; what a commit changed.
"""
import ctypes
import weakref

import numpy as np

from . import _errors
from ._library import _PROGRESS, _STAGES, Mesh, _answer, _Arrays, _Changes, _copied, _library, _Watch

WAYS = "nothing", "flips", "batch", "rebuild"     # in the order of pbw_way


def _data(array):
    return None if array is None else array.ctypes.data


class Handle:
    """A pbw_live, made of a Mesh, which it does not refer to."""

    def __init__(self, mesh, progress):
        self.dim, self.weighted, self.threads = mesh.points.shape[1], mesh.weights is not None, mesh.threads
        self._size, self._thrown = len(mesh.points), []
        self._watch, live = _Watch(), ctypes.c_void_p()
        if progress:
            self._watch.progress = _caller(progress, self._thrown)
        self._ask(lambda: _library.pbw_python_live(mesh._arrays(), self._watch, live))
        self._live = live
        weakref.finalize(self, _library.pbw_live_free, live)

    def _ask(self, call):
        """call(), which returns a status, while this handle's watch tells the library to stop after Ctrl-C."""
        def ask(arrays):
            self._watch.stop = arrays.stop
            status = call()
            if self._thrown:
                raise self._thrown.pop()
            return 0 if status == _errors.DEGENERATE else status

        _answer(_Arrays(), self._size, ask, np.empty((self._size, self.dim)))

    def insert(self, points, weights):
        """The numbers of the new points."""
        ids = np.empty(len(points), np.int32)
        self._size += len(points)
        self._queued(_library.pbw_live_insert(self._live, points, _data(weights), len(points), ids), points, weights)
        return ids

    def remove(self, ids):
        self._queued(_library.pbw_live_remove(self._live, ids, len(ids)))

    def move(self, ids, points):
        self._queued(_library.pbw_live_move(self._live, _data(ids), points, len(points)), points)

    def _queued(self, status, points=np.empty((0, 2)), weights=None):
        if status == _errors.ARGUMENT:
            raise ValueError("ids must be numbers of points that are not removed; to remove, each once")
        if status:
            raise _errors.from_status(status, _library.pbw_status_string(status).decode(), points, weights)

    def commit(self, changes):
        """way, deleted, made, points; None without changes, which is quicker."""
        found, made = _Changes(), []
        self._ask(lambda: _library.pbw_live_commit(self._live, found if changes else None))
        try:
            if changes:
                corners = self.dim + 1
                made = [WAYS[found.way], _copied(found.deleted, (found.deleted_count, corners), np.int32),
                        _copied(found.made, (found.made_count, corners), np.int32),
                        _copied(found.points, found.point_count, np.int32)]
                made = [np.empty((0, corners), np.int32) if a is None else a for a in made[:3]] + [
                    np.empty(0, np.int32) if made[3] is None else made[3]]
        finally:
            _library.pbw_changes_free(found)
        return made or None

    def mesh(self):
        """The triangulation after the last commit."""
        views = []

        def view():
            status, points, simplices = ctypes.c_int(), ctypes.c_size_t(), ctypes.c_size_t()
            mesh = _library.pbw_python_live_view(self._live, status, points, simplices)
            if mesh:
                views.append((mesh, points.value, simplices.value))
            return status.value

        try:
            self._ask(view)
            (mesh, count, simplex_count), = views
            made = [np.empty(shape, np.int32)
                    for shape in ((simplex_count, self.dim + 1), (simplex_count, self.dim + 1), count, count)]
            points, weights = np.empty((count, self.dim)), np.empty(count)
            _library.pbw_python_copy(mesh, *made)
            _library.pbw_python_copy_points(mesh, points, weights)
        finally:
            for mesh, _, _ in views:
                _library.pbw_python_free(mesh)
        return Mesh(points, weights if self.weighted else None, self.threads, None, made)


def _caller(progress, thrown):
    def call(stage, done):
        try:
            progress(_STAGES[stage], done)
        except BaseException as e:
            thrown.append(e)
        return bool(thrown)
    return _PROGRESS(call)
