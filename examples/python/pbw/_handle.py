"""A live triangulation of the library's.

In: arrays that were checked.  Out: Meshes; what a commit changed.
"""
import ctypes
import threading
import weakref
from contextlib import contextmanager

import numpy as np

from . import _errors
from ._library import _PROGRESS, _STAGES, Mesh, _answer, _Arrays, _Changes, _copied, _library, _Watch

WAYS = "nothing", "flips", "batch", "rebuild"     # in the order of pbw_way


def _data(array):
    return None if array is None else array.ctypes.data


class Handle:
    """A pbw_live, made of a Mesh, which it does not refer to.  One call at a time: others wait for it, also for one
    that Ctrl-C ended and that has not stopped yet.  A callback must not call its own handle."""

    def __init__(self, mesh, progress):
        self.dim, self.weighted, self.threads = mesh.points.shape[1], mesh.weights is not None, mesh.threads
        self._size, self._thrown = len(mesh.points), []
        self._watch, live, self.version = _Watch(), ctypes.c_void_p(), 0
        self._lock, self._worker = threading.Lock(), None
        if progress:
            self._watch.progress = _caller(progress, self._thrown)
        self._ask(lambda: _library.pbw_python_live(mesh._arrays(), self._watch, live))
        self._live = live
        weakref.finalize(self, _library.pbw_live_free, live)

    @contextmanager
    def _alone(self):
        with self._lock:
            self._worker = threading.get_ident()
            try:
                yield
            finally:
                self._worker = None

    def _refuse_callbacks(self):
        if self._worker == threading.get_ident():
            raise RuntimeError("the triangulation is in use by the call that this callback belongs to")

    def _ask(self, call):
        """call(), which returns a status, while this handle's watch tells the library to stop after Ctrl-C.  Another
        thread may run it: it ends there, whatever becomes of this one."""
        def ask(arrays):
            with self._alone():
                self._watch.stop = arrays.stop
                self._asked = arrays                 # has what the watch points to
                status = call()
                if self._thrown:
                    raise self._thrown.pop()
            return 0 if status == _errors.DEGENERATE else status

        self._refuse_callbacks()
        _answer(_Arrays(), self._size, ask, np.empty((self._size, self.dim)))

    def insert(self, points, weights):
        """The numbers of the new points."""
        ids = np.empty(len(points), np.int32)
        self._size += len(points)
        self._queue(lambda: _library.pbw_live_insert(self._live, points, _data(weights), len(points), ids), points,
                    weights)
        return ids

    def remove(self, ids):
        self._queue(lambda: _library.pbw_live_remove(self._live, ids, len(ids)))

    def move(self, ids, points):
        self._queue(lambda: _library.pbw_live_move(self._live, _data(ids), points, len(points)), points)

    def _queue(self, call, points=np.empty((0, 2)), weights=None):
        self._refuse_callbacks()
        with self._alone():
            status = call()
        if status == _errors.ARGUMENT:
            raise ValueError("ids must be numbers of points that are not removed; to remove, each once")
        if status:
            raise _errors.from_status(status, _library.pbw_status_string(status).decode(), points, weights)

    def commit(self, changes):
        """way, deleted, made, points; None without changes, which is quicker."""
        found, made = _Changes(), []

        def commit():
            status = _library.pbw_live_commit(self._live, found if changes else None)
            self.version += 1
            try:
                if changes:
                    corners = self.dim + 1
                    made.append(WAYS[found.way])
                    for pointer, shape in ((found.deleted, (found.deleted_count, corners)),
                                           (found.made, (found.made_count, corners)),
                                           (found.points, (found.point_count,))):
                        array = _copied(pointer, shape, np.int32)
                        made.append(np.empty((0, *shape[1:]), np.int32) if array is None else array)
            finally:
                _library.pbw_changes_free(found)
            return status

        self._ask(commit)
        return made or None

    def mesh(self):
        """The triangulation after the last commit, and the number of that commit."""
        views = []

        def view():
            status, count, simplices = ctypes.c_int(), ctypes.c_size_t(), ctypes.c_size_t()
            mesh = _library.pbw_python_live_view(self._live, status, count, simplices)
            if mesh:
                try:
                    shape = simplices.value, self.dim + 1
                    made = [np.empty(s, np.int32) for s in (shape, shape, count.value, count.value)]
                    points, weights = np.empty((count.value, self.dim)), np.empty(count.value)
                    _library.pbw_python_copy(mesh, *made)
                    _library.pbw_python_copy_points(mesh, points, weights)
                    views.append((points, weights if self.weighted else None, made, self.version))
                finally:
                    _library.pbw_python_free(mesh)
            return status.value

        self._ask(view)
        (points, weights, made, version), = views
        return Mesh(points, weights, self.threads, None, made), version


def _caller(progress, thrown):
    def call(stage, done):
        try:
            progress(_STAGES[stage], done)
        except BaseException as e:
            thrown.append(e)
        return bool(thrown)
    return _PROGRESS(call)
