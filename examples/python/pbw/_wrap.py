"""Closed surfaces around any model: wrap, which calls pbw_wrap.h.

In: the caller's arrays, converted and checked.  Out: a Wrap of arrays that Python owns.
"""
import ctypes

import numpy as np

from . import _errors
from ._library import _PROGRESS, _Watch, _copied, _fit, _library, _pointers, _run
from ._tets import _ImproveReport, _at_points, _check_number, _checked, _made, _plain, _take_facets

_size, _double = ctypes.c_size_t, ctypes.c_double


class _WrapInput(ctypes.Structure):
    """pbw_wrap_input."""
    _fields_ = [("points", ctypes.c_void_p), ("point_count", _size), ("triangles", ctypes.c_void_p),
                ("triangle_count", _size), ("segments", ctypes.c_void_p), ("segment_count", _size),
                ("singles", ctypes.c_void_p), ("single_count", _size)]


class _WrapOptions(ctypes.Structure):
    """pbw_wrap_options."""
    _fields_ = [("alpha", _double), ("offset", _double), *_pointers("alpha_at alpha_user seeds"),
                ("seed_count", _size), ("fast", ctypes.c_int), ("closing", ctypes.c_int), ("fill", _double),
                ("most", _double), ("seconds", _double)]


class _WrapResult(ctypes.Structure):
    """pbw_wrap_result."""
    _fields_ = [*((name, _size) for name in ("point_count", "vertex_count", "facet_count", "tet_count")),
                *_pointers("points facets elements corners neighbors memory")]


class _WrapReport(ctypes.Structure):
    """pbw_wrap_report."""
    _fields_ = [("refusal", ctypes.c_int), *((name, _double) for name in ("alpha", "offset", "volume", "area")),
                ("open_edges", _size), ("both_sides", _double), ("shell", ctypes.c_int), ("closing", _double),
                *((name, _size) for name in ("components", "unused_seeds", "crossings", "projections", "carved",
                                             "repairs", "dropped", "rounds")),
                ("seconds", _double * 3)]


class _WrapSolidOptions(ctypes.Structure):
    """pbw_wrap_solid_options."""
    _fields_ = [("size", _double), ("wrap", _WrapOptions), ("stay", ctypes.c_int), ("target", _double),
                ("seconds", _double), *_pointers("stage")]


class _WrapSolidReport(ctypes.Structure):
    """pbw_wrap_solid_report."""
    _fields_ = [("wrap", _WrapReport), ("improve", _ImproveReport), ("size", _double), ("raised", _double),
                *((name, _size) for name in ("points", "facets", "tets")), ("closed", ctypes.c_int),
                ("late", ctypes.c_int), *((name, _double * 2) for name in ("before", "after", "seconds"))]


_fit(_library, 17, _WrapInput, _WrapOptions, _WrapResult, _WrapReport)
_fit(_library, 25, _WrapSolidOptions, _WrapSolidReport)
_REFUSALS = {1: "there is nothing to wrap", 2: "all points are at one place: alpha says how large the wrap shall be",
             3: "the offset is below 1e-9 of the largest coordinate", 4: "more tetrahedra than most",
             5: "the seconds were over before there was a wrap"}


def _failed(status, refusal, points):
    """What to raise."""
    return (_errors.Error(_REFUSALS[refusal]) if refusal
            else _errors.from_status(status, _library.pbw_status_string(status).decode(), points, None))


def _filled(points, triangles, size, target, most):
    """Good tetrahedra in a wrap, a Tets: for solid."""
    given = _WrapInput(points.ctypes.data, len(points), triangles.ctypes.data, len(triangles))
    how, report = _WrapSolidOptions(size), _WrapSolidReport()
    how.target, how.wrap.most = target, most

    def finish(made, mesh):                              # one region, and no patches
        made.regions = np.zeros(len(made.tets), np.int32)
        _take_facets(made, np.full((len(made.tets), 4), -1, np.int32), np.array([-1]), np.array([0, -1]))
        made.edges = np.empty((0, 2), np.int32)

    status, made = _made(lambda watch, mesh, out: _library.pbw_python_wrap_solid(
        ctypes.byref(given), ctypes.byref(how), watch, mesh, out), report, finish)
    if status:
        raise _failed(status, report.wrap.refusal, points)
    whole = made.report
    made.report = {**whole["improve"], "wrap": whole["wrap"], "distance_before": whole["before"],
                   "distance": whole["after"], **{name: whole[name] for name in ("size", "raised", "closed")}}
    return made


class Wrap:
    """A closed, oriented surface, and the tetrahedra inside of it.

    points (n, 3): first the vertices of the surface, then those inside; faces (k, 3), turned outward; elements: per
    face the number of the nearest triangle, segment or point that was wrapped, numbered through in this order; tets
    (m, 4), positive; neighbors (m, 4), -1 at the surface; vertex_count.
    report: a dictionary; alpha and offset that were used, volume, area, both_sides: the share of the surface that is
    on both sides of something open, shell: 1 if that is more than 0.4, and then closing: an alpha that closes the
    model, 0 if none does.
    """

    def __init__(self, result, report):
        self.points = _copied(result.points, (result.point_count, 3), np.float64)
        self.vertex_count = result.vertex_count
        self.faces = _copied(result.facets, (result.facet_count, 3), np.int32)
        self.elements = _copied(result.elements, result.facet_count, np.int32)
        self.tets = _copied(result.corners, (result.tet_count, 4), np.int32)
        self.neighbors = _copied(result.neighbors, (result.tet_count, 4), np.int32)
        self.report = _plain(report)

    def __repr__(self):
        return "<pbw.Wrap: %d faces, %d vertices, %d tetrahedra, volume %.6g>" % (
            len(self.faces), self.vertex_count, len(self.tets), self.report["volume"])


def wrap(points, triangles=None, segments=None, singles=None, alpha=0, offset=0, seeds=None, fast=False,
         closing=False, fill=0, most=50e6, seconds=0):
    """Wraps triangles (m, 3), segments (s, 2) and single points, all by rows of points (n, 3), in a closed surface
    that touches none of them and encloses all; holes, crossings and gaps are fine.  Without any of the three, all
    points are wrapped.

    alpha: radius of balls that do not pass, so that holes and gaps below twice that are closed; 0 = 1/50 of the
    diagonal; or a function of a point (x, y, z), below that.  offset: of the vertices from the model; 0 = alpha / 30.
    seeds (c, 3): cavities with one of them are carved from inside, too.  fast=True: half the time, more faces.
    closing=True: where the wrap is a shell around both sides of an open model, looks for an alpha that closes it.
    fill: length of edges inside, for rounder tetrahedra; 0 = no vertices for that.
    seconds of all threads' processor time, at most; 0 = no limit.

    Returns a Wrap.
    """
    points = _checked("points", points, 3, np.float64)
    if triangles is None and segments is None and singles is None:
        singles = np.arange(len(points))
    rows = [_checked(name, np.empty((0, columns), int) if array is None else array, columns, np.uint32, len(points))
            for name, array, columns in (("triangles", triangles, 3), ("segments", segments, 2),
                                         ("singles", None if singles is None else np.reshape(singles, (-1, 1)), 1))]
    given = _WrapInput(points.ctypes.data, len(points), *(part for array in rows
                                                           for part in (array.ctypes.data, len(array))))
    for name, value in (("alpha", alpha), ("offset", offset), ("fill", fill), ("seconds", seconds)):
        if not callable(value):
            _check_number(name, value, 0, np.finfo(float).max)
    _check_number("most", most, 1, np.finfo(float).max)
    how = _WrapOptions(0 if callable(alpha) else alpha, offset)
    how.fast, how.closing, how.fill, how.most, how.seconds = fast, closing, fill, most, seconds
    if seeds is not None:
        seeds = _checked("seeds", seeds, 3, np.float64)
        how.seeds, how.seed_count = seeds.ctypes.data, len(seeds)
    thrown, status = [], []
    if callable(alpha):
        keep = _at_points(alpha, thrown)
        how.alpha_at = ctypes.cast(keep, ctypes.c_void_p)
    result, report, stop = _WrapResult(), _WrapReport(), ctypes.c_int()
    watch = _Watch(ctypes.pointer(stop), _PROGRESS())
    _run(lambda: status.append(_library.pbw_python_wrap(ctypes.byref(given), ctypes.byref(how), ctypes.byref(watch),
                                                        ctypes.byref(result), ctypes.byref(report))), stop)
    try:
        if thrown:
            raise thrown[0]
        if status[0]:
            raise _failed(status[0], report.refusal, points)
        return Wrap(result, report)
    finally:
        _library.pbw_wrap_free(ctypes.byref(result))
