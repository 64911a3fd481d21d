"""Tetrahedral meshes: improve and solid, which call pbw_improve.h and pbw_mesh3.h.

In: the caller's arrays, converted and checked.  Out: a Tets of arrays that Python owns.
"""
import ctypes

import numpy as np

from . import _errors
from ._library import _PROGRESS, _Watch, _copied, _fit, _library, _pointers, _run

_size, _double = ctypes.c_size_t, ctypes.c_double


class _Mesh(ctypes.Structure):
    """pbw_tets."""
    _fields_ = [("point_count", _size), ("tet_count", _size),
                *_pointers("points corners regions marks neighbors original patches edges edge_origins"),
                ("edge_count", _size), *_pointers("memory")]


class _Quality(ctypes.Structure):
    """pbw_quality."""
    _fields_ = [*((name, _double) for name in ("least", "permille", "percent", "largest")), ("below", _size * 4),
                ("bins", _size * 18), ("volume", _double), ("least_sine", _double)]


class _ImproveOptions(ctypes.Structure):
    """pbw_improve_options."""
    _fields_ = [("target", _double), ("seconds", _double), ("passes", ctypes.c_int), ("feature_angle", _double),
                *_pointers("project project_user"), ("distance", _double), *_pointers("sizes"),
                ("rounds", ctypes.c_int), ("smoother", ctypes.c_int)]


class _ImproveReport(ctypes.Structure):
    """pbw_improve_report."""
    _fields_ = [("before", _Quality), ("after", _Quality),
                *((name, _size) for name in ("turned", "removals", "boundary_removals", "smoothings", "slides",
                                             "peelings", "flips", "contractions", "insertions", "splits",
                                             "moves", "left")),
                ("passes", ctypes.c_int), ("rounds", ctypes.c_int)]


class _SolidInput(ctypes.Structure):
    """pbw_solid_input."""
    _fields_ = [("points", ctypes.c_void_p), ("point_count", _size), ("triangles", ctypes.c_void_p),
                ("triangle_count", _size), *_pointers("patches value value_user"), ("box", _double * 6)]


class _SolidOptions(ctypes.Structure):
    """pbw_solid_options."""
    _fields_ = [("size", _double), ("least_size", _double), *_pointers("size_at size_user"), ("curvature", _double),
                ("nested", ctypes.c_int), ("close", ctypes.c_int), ("sharp", ctypes.c_int), ("most", _double),
                *_pointers("plan plan_user"), ("feature_angle", _double), ("distance", _double),
                ("rounds", ctypes.c_int), ("improve", _ImproveOptions)]


class _Hole(ctypes.Structure):
    """pbw_solid_hole."""
    _fields_ = [("edges", _size), ("length", _double), ("place", _double * 3), ("closed", ctypes.c_int)]


class _Boundary(ctypes.Structure):
    """pbw_solid_boundary."""
    _fields_ = [*((name, _size) for name in ("facet_count", "edge_count", "hole_count")),
                *_pointers("facets corners patches sides edges holes memory")]


_SHARP = ("auto", "all", "some", "none")          # as PBW_SOLID_SHARP_...
_SIZE_AT = ctypes.CFUNCTYPE(_double, ctypes.c_void_p, ctypes.POINTER(_double))


class _SolidReport(ctypes.Structure):
    """pbw_solid_report."""
    _fields_ = [*((name, _size) for name in ("open_edges", "crowded_edges", "doubles", "shells", "holes")),
                ("hole", _Hole * 8),
                *((name, _double) for name in ("hole_share", "thickness", "estimate")),
                ("crossings", _size), ("refusal", ctypes.c_int), ("regions", _size), ("sharp", ctypes.c_int),
                ("sharp_share", _double),
                *((name, _size) for name in ("corners", "sharp_edges", "acute_edges")),
                ("least_angle", _double), *((name, _size) for name in ("missing_edges", "bad_edges", "bad_points")),
                ("places", _double * 3 * 8),
                ("facets", _size),
                ("euler", ctypes.c_long), ("input_euler", ctypes.c_long), ("distance", _double), ("size", _double),
                ("input_volume", _double), ("rounds", ctypes.c_int), ("settled", ctypes.c_int),
                ("seconds", _double * 4), ("improve", _ImproveReport)]


_fit(_library, 8, _Mesh, _Quality, _ImproveOptions, _ImproveReport, _SolidInput, _SolidOptions, _SolidReport,
     _Boundary)


class Tets:
    """points, tets (positive, four points each), regions, neighbors (-1 on the boundary), original (per point its
    number in the input, -1 if it is new) and report: a dictionary, in which before and after have dihedral angles in
    degrees."""

    def __init__(self, mesh, report):
        tets = (mesh.tet_count, 4)
        self.points = _copied(mesh.points, (mesh.point_count, 3), np.float64)
        self.tets = _copied(mesh.corners, tets, np.int32)
        self.regions = _copied(mesh.regions, mesh.tet_count, np.uint32)
        self.neighbors = _copied(mesh.neighbors, tets, np.int32)
        self.original = _copied(mesh.original, mesh.point_count, np.int32)
        self.report = _plain(report)

    def __repr__(self):
        return "<pbw.Tets: %d tetrahedra, %d points, dihedral angles from %.4g to %.4g degrees>" % (
            len(self.tets), len(self.points), *(self.report.get("improve", self.report)["after"][k]
                                                for k in ("least", "largest")))


def _plain(value):
    if isinstance(value, ctypes.Structure):
        return {name: _plain(getattr(value, name)) for name, _ in value._fields_}
    if isinstance(value, ctypes.Array) and issubclass(value._type_, ctypes.Structure):
        return [_plain(one) for one in value]
    return np.array(value).tolist() if isinstance(value, ctypes.Array) else value


def _checked(name, array, columns, kind, count=None):
    """A C array of rows of so many columns; indices must be below count."""
    array = np.asarray(array)
    if array.ndim != 2 or array.shape[1] != columns:
        raise ValueError("%s has the shape %s: rows of %d are needed" % (name, array.shape, columns))
    if count is not None and array.size and (array.dtype.kind not in "iu" or array.min() < 0 or array.max() >= count):
        raise ValueError("%s must be whole numbers from 0 to %d" % (name, count - 1))
    return np.ascontiguousarray(array, dtype=kind)


def _made(call, report):
    """A status and the Tets that call(watch, mesh, report) makes, in a thread; None if it fails."""
    mesh, stop, thrown = _Mesh(), ctypes.c_int(), []
    watch = _Watch(ctypes.pointer(stop), _PROGRESS())
    status = []

    def work():
        try:
            status.append(call(ctypes.byref(watch), ctypes.byref(mesh), ctypes.byref(report)))
        except BaseException as e:
            thrown.append(e)

    _run(work, stop)
    if thrown:
        raise thrown[0]
    if status[0]:
        return status[0], None
    try:
        return 0, Tets(mesh, report)
    finally:
        _library.pbw_tets_free(ctypes.byref(mesh))


def _check_number(name, value, least, most):
    if not least <= value <= most:
        raise ValueError("%s must be from %g to %g, not %r" % (name, least, most, value))


_SMOOTHERS = "odt", "lloyd", "laplace"


def improve(points, tets, target=30, seconds=0, feature_angle=40, regions=None, fixed=None, smooth=None, rounds=5):
    """Tetrahedra with better dihedral angles: from target to 180 - target degrees, where that can be had.

    points: (n, 3); tets: (m, 4); regions: m whole numbers, whose interfaces are kept; fixed: n booleans, True for
    points that stay; seconds: ends after that time, 0 = when nothing helps any more; smooth: before that, so many
    rounds move points to better means, "odt", "lloyd" or "laplace"; target None: nothing else.  Returns a Tets.
    """
    points = _checked("points", points, 3, np.float64)
    tets = _checked("tets", tets, 4, np.uint32, len(points))
    regions = None if regions is None else np.ascontiguousarray(regions, dtype=np.uint32)
    marks = None if fixed is None else np.where(np.asarray(fixed, bool), 2, 0).astype(np.uint8)
    for name, array, count in (("regions", regions, len(tets)), ("fixed", marks, len(points))):
        if array is not None and array.shape != (count,):
            raise ValueError("%s has the shape %s: %d numbers are needed" % (name, array.shape, count))
    given = _Mesh(len(points), len(tets), points.ctypes.data, tets.ctypes.data,
                  None if regions is None else regions.ctypes.data, None if marks is None else marks.ctypes.data)
    if smooth is not None and smooth not in _SMOOTHERS:
        raise ValueError("smooth is %r: one of %s is needed" % (smooth, ", ".join(_SMOOTHERS)))
    if target is not None:
        _check_number("target", target, 1, 60)
    how = _ImproveOptions(target or 0, seconds, -1 if target is None else 0, feature_angle)
    if smooth is not None:
        how.rounds, how.smoother = rounds, _SMOOTHERS.index(smooth)
    message = ctypes.create_string_buffer(128)
    status, made = _made(lambda watch, mesh, report: _library.pbw_python_improve(
        ctypes.byref(given), ctypes.byref(how), watch, message, mesh, report), _ImproveReport())
    if status:
        text = message.value.decode() or _library.pbw_status_string(status).decode()
        raise _errors.from_status(status, text, points, None)
    return made


def solid(vertices, faces, size=0, target=30, feature_angle=40, rounds=16, patches=None, nested=False,
          least_size=0, curvature=0, sharp="auto", close=False, most=50e6):
    """Tetrahedra inside a closed surface: vertices (n, 3), faces (m, 3), one or several shells.

    size: length of edges, 0 = 1/40 of the diagonal, or a function of a point (x, y, z), below 1/40 of the diagonal.
    They are shorter in thin walls, and with curvature=c at most c radii of curvature, but not below least_size.
    Edges of the surface that bend by more than feature_angle degrees are kept, and those between faces of different
    patches, one number a face.  sharp: which of the edges that bend are kept, "all", "some", "none" or "auto".
    nested=True: shells inside of others bound regions, else every second is a cavity, and shells that cross are one
    body.
    Surfaces that are mostly holes or very thin are refused, unless close=True, and more than `most` tetrahedra.

    Returns a Tets whose regions are numbers of shells, with facets (of the boundary and between regions), their
    patches (-1 where a hole is closed), sides (regions, -1 outside) and features (edges) beside.  Its report has
    bad_edges, bad_points, missing_edges and open_edges, all 0 if the boundary is a manifold on the surface, and the
    largest holes.
    """
    vertices = _checked("vertices", vertices, 3, np.float64)
    faces = _checked("faces", faces, 3, np.uint32, len(vertices))
    given = _SolidInput(vertices.ctypes.data, len(vertices), faces.ctypes.data, len(faces))
    if patches is not None:
        patches = np.ascontiguousarray(patches, dtype=np.uint32)
        if patches.shape != (len(faces),):
            raise ValueError("patches needs one number for each face")
        given.patches = patches.ctypes.data
    for name, value in (("size", size), ("least_size", least_size), ("curvature", curvature)):
        if not callable(value):
            _check_number(name, value, 0, np.finfo(float).max)
    if target > 0:
        _check_number("target", target, 1, 60)
    if sharp not in _SHARP:
        raise ValueError("sharp must be one of " + ", ".join(_SHARP))
    _check_number("most", most, 1, np.finfo(float).max)
    how = _SolidOptions(0 if callable(size) else size, least_size, None, None, curvature, nested, close,
                        _SHARP.index(sharp), most, None, None, feature_angle, 0, rounds, _ImproveOptions(target))
    thrown = []
    if callable(size):
        def at(user, point):
            try:
                return float(size((point[0], point[1], point[2])))
            except BaseException as e:
                thrown.append(e)
                return np.inf
        keep = _SIZE_AT(at)
        how.size_at = ctypes.cast(keep, ctypes.c_void_p)
    boundary = _Boundary()
    status, made = _made(lambda watch, mesh, report: _library.pbw_python_solid(
        ctypes.byref(given), ctypes.byref(how), watch, mesh, ctypes.byref(boundary), report), _SolidReport())
    if made is not None:
        made.facets = _copied(boundary.facets, (boundary.facet_count, 3), np.int32)
        made.patches = _copied(boundary.patches, boundary.facet_count, np.int32)
        made.sides = _copied(boundary.sides, (boundary.facet_count, 2), np.int32)
        made.features = _copied(boundary.edges, (boundary.edge_count, 2), np.int32)
        _library.pbw_solid_boundary_free(ctypes.byref(boundary))
    if thrown:
        raise thrown[0]
    if status == _errors.DEGENERATE:
        raise _errors.Error("nothing is inside of the surface: it is an open sheet, or mostly holes, which close=True "
                            "closes, or thinner than the size")
    if status:
        raise _errors.from_status(status, _library.pbw_status_string(status).decode(), vertices, None)
    return made
