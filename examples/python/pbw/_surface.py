"""Surfaces: check_surface, which calls pbw_surface.h.

In: the caller's arrays, converted and checked.  Out: a SurfaceFaults of arrays that Python owns.
"""
import ctypes

import numpy as np

from . import _errors
from ._library import _PROGRESS, _Watch, _copied, _fit, _library, _pointers, _run
from ._tets import _checked

_size = ctypes.c_size_t


class _Faults(ctypes.Structure):
    """pbw_surface_faults."""
    _fields_ = [("crossing_count", _size), *_pointers("crossings segments"), ("flat_count", _size),
                *_pointers("flat"), ("duplicate_count", _size), *_pointers("duplicates"), ("edge_count", _size),
                *_pointers("edges edge_triangles"), ("repeated_count", _size), *_pointers("repeated memory")]


_fit(_library, 16, _Faults)


class SurfaceFaults:
    """What is wrong with a surface; true if anything is.

    Corners are compared by place: triangles may have points of their own.  Of points at one place the first is named.
    crossings (k, 2): triangles that meet elsewhere than in common corners and edges, exactly; segments (k, 2, 3):
    what the two have in common, from one point to another, rounded.
    flat: triangles without area.  duplicates (k, 2): a triangle, and the first one with the same corners.
    edges (k, 2): without exactly two triangles, one each way round; edge_triangles: how many each has: 1, open; 2,
    turned alike; or more.
    repeated (k, 2): a point, and the first one at its place; that is no fault here.
    """

    def __init__(self, found):
        def rows(pointer, count, *shape, kind=np.int32):
            return _copied(pointer, (count, *shape), kind) if count else np.empty((0, *shape), kind)

        self.crossings = rows(found.crossings, found.crossing_count, 2)
        self.segments = rows(found.segments, found.crossing_count, 2, 3, kind=np.float64)
        self.flat = rows(found.flat, found.flat_count)
        self.duplicates = rows(found.duplicates, found.duplicate_count, 2)
        self.edges = rows(found.edges, found.edge_count, 2)
        self.edge_triangles = rows(found.edge_triangles, found.edge_count)
        self.repeated = rows(found.repeated, found.repeated_count, 2)

    def __bool__(self):
        return any(len(a) > 0 for a in (self.crossings, self.flat, self.duplicates, self.edges))

    def __repr__(self):
        return ("<pbw.SurfaceFaults: %d pairs of triangles that meet, %d triangles without area, %d again, %d edges "
                "without two triangles>" % (len(self.crossings), len(self.flat), len(self.duplicates),
                                            len(self.edges)))


def check_surface(points, triangles, *, threads=0):
    """Finds what is wrong with a surface: points (n, 3), triangles (m, 3).  Returns a SurfaceFaults."""
    points = _checked("points", points, 3, np.float64)
    triangles = _checked("triangles", triangles, 3, np.uint32, len(points))
    found, stop, status, made = _Faults(), ctypes.c_int(), [], []
    watch = _Watch(ctypes.pointer(stop), _PROGRESS())

    def work():
        try:
            status.append(_library.pbw_python_crossings(
                points.ctypes.data_as(ctypes.c_void_p), _size(len(points)),
                triangles.ctypes.data_as(ctypes.c_void_p), _size(len(triangles)), threads, ctypes.byref(watch),
                ctypes.byref(found)))
            made.append(SurfaceFaults(found))
        finally:
            _library.pbw_surface_faults_free(ctypes.byref(found))

    _run(work, stop)
    if status[0]:
        raise _errors.from_status(status[0], _library.pbw_status_string(status[0]).decode(), points, None)
    return made[0]
