"""The shared library of pbw_python.c, and a triangulation as it makes it.

In: arrays that were checked.  Out: a Mesh of read-only arrays, which only the library reads; users get copies.
"""
import ctypes
import os
import threading

import numpy as np

from . import _errors

_PROGRESS = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_int, ctypes.c_double)
_STAGES = ("order", "build", "output", "check")


class _Arrays(ctypes.Structure):
    """struct arrays of pbw_python.c."""
    _fields_ = [("dim", ctypes.c_int), ("point_count", ctypes.c_size_t), ("simplex_count", ctypes.c_size_t),
                ("points", ctypes.c_void_p), ("simplices", ctypes.c_void_p), ("neighbors", ctypes.c_void_p)]


def _load():
    here = os.path.dirname(os.path.abspath(__file__))
    name = "libpbw_python.so"
    places = [os.environ.get("PBW_LIBRARY"), os.path.join(here, name),
              os.path.join(here, "..", "..", "..", "build", name)]
    for place in places:
        if place and os.path.exists(place):
            break
    else:
        raise ImportError("%s is not there: run make or pip install, or set PBW_LIBRARY to its path" % name)
    try:
        library = ctypes.CDLL(place)
        _declare(library)
    except (AttributeError, OSError) as e:
        raise ImportError("%s does not fit this version of pbw: %s" % (place, e)) from e
    return library


def _declare(library):
    doubles = np.ctypeslib.ndpointer(np.float64, flags="C_CONTIGUOUS")
    ints = np.ctypeslib.ndpointer(np.int32, flags="C_CONTIGUOUS")
    size, integer, arrays = ctypes.c_size_t, ctypes.POINTER(ctypes.c_int), ctypes.POINTER(_Arrays)
    library.pbw_python_build.restype = ctypes.c_void_p
    library.pbw_python_build.argtypes = [ctypes.c_int, doubles, ctypes.c_void_p, size, ctypes.c_int, integer,
                                         _PROGRESS, integer, ctypes.POINTER(size)]
    library.pbw_python_copy.restype = library.pbw_python_free.restype = None
    library.pbw_python_copy.argtypes = [ctypes.c_void_p, ints, ints, ints, ints]
    library.pbw_python_free.argtypes = [ctypes.c_void_p]
    library.pbw_python_find.argtypes = [arrays, doubles, size, ctypes.c_int, ints]
    library.pbw_python_stars.restype = ctypes.c_int64
    library.pbw_python_stars.argtypes = [arrays, ints, ctypes.c_void_p]
    library.pbw_status_string.restype = ctypes.c_char_p
    library.pbw_version.restype = ctypes.c_int


_library = _load()
_number = _library.pbw_version()
version = "%d.%d.%d" % (_number // 10000, _number // 100 % 100, _number % 100)


def _run(work, stop):
    """Runs work() in a thread.  Ctrl-C is seen by the main thread, and only between two steps of Python: it must not
    be the one that works.  An exception in it sets stop, which ends the library's work within a tenth of a second; a
    callback of the user may take longer, so the wait for that is bounded, and work() holds what it uses."""
    thread = threading.Thread(target=work)
    try:
        thread.start()
        while thread.is_alive():
            thread.join(0.1)
    except BaseException:
        stop.value = 1
        if thread.ident is not None:
            thread.join(1)
        raise


def _triangulate(points, weights, threads, progress):
    """simplices, neighbors, incident, canonical."""
    count, dim = points.shape
    stop, status, simplex_count = ctypes.c_int(), ctypes.c_int(), ctypes.c_size_t()
    arrays, thrown = [], []

    def call(stage, done):
        try:
            progress(_STAGES[stage], done)
        except BaseException as e:
            thrown.append(e)
        return bool(thrown)

    def work():
        try:
            mesh = _library.pbw_python_build(dim, points, None if weights is None else weights.ctypes.data, count,
                                             threads, stop, _PROGRESS(call) if progress else _PROGRESS(), status,
                                             simplex_count)
            if mesh:
                try:
                    shape = (simplex_count.value, dim + 1)
                    made = [np.empty(s, np.int32) for s in (shape, shape, count, count)]
                    _library.pbw_python_copy(mesh, *made)
                    arrays.extend(made)
                finally:
                    _library.pbw_python_free(mesh)
        except BaseException as e:
            thrown.append(e)

    if count < 1000 and progress is None:
        work()                     # sooner done than a thread is started
    else:
        _run(work, stop)
    if thrown:
        raise thrown[0]
    if not arrays:
        text = _library.pbw_status_string(status).decode()
        raise _errors.from_status(status.value, text, points, weights)
    return arrays


class Mesh:
    """points, weights (or None), simplices, neighbors, incident, canonical: as in pbw_mesh, -1 for PBW_NONE."""
    __slots__ = ("points", "weights", "simplices", "neighbors", "incident", "canonical")

    def __init__(self, points, weights, threads, progress):
        self.points, self.weights = points, weights
        self.simplices, self.neighbors, self.incident, self.canonical = _triangulate(points, weights, threads,
                                                                                     progress)
        for array in (points, self.simplices, self.neighbors, self.incident, self.canonical):
            array.flags.writeable = False

    def _arrays(self):
        count, dim = self.points.shape
        return _Arrays(dim, count, len(self.simplices), self.points.ctypes.data, self.simplices.ctypes.data,
                       self.neighbors.ctypes.data)

    def find(self, queries, every):
        """For each query the lowest simplex that has it, or -1 - (a simplex to that side) if it is outside."""
        found = np.empty(len(queries), np.int32)
        if _library.pbw_python_find(self._arrays(), queries, len(queries), every, found):
            raise MemoryError("no memory to find the simplices of %d points" % len(queries))
        return found

    def stars(self):
        """indptr and indices of the neighbours of each point, ascending."""
        indptr, arrays = np.empty(len(self.points) + 1, np.int32), self._arrays()
        count = _library.pbw_python_stars(arrays, indptr, None)
        indices = np.empty(max(count, 0), np.int32)
        if count < 0 or _library.pbw_python_stars(arrays, indptr, indices.ctypes.data) < 0:
            raise MemoryError("no memory for the neighbours of %d points, or more than 2^31 - 1" % len(self.points))
        return indptr, indices
