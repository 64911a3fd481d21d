"""Tetrahedral meshes: improve, solid and fill, which call pbw_improve.h, pbw_mesh3.h and pbw_fill.h.

In: the caller's arrays, converted and checked.  Out: a Tets of arrays that Python owns.
"""
import ctypes
import itertools

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
    _fields_ = [("size", _double), ("least_size", _double), *_pointers("size_at size_user region_sizes"),
                ("region_size_count", _size), ("curvature", _double),
                ("gradation", _double), ("nested", ctypes.c_int), ("close", ctypes.c_int), ("sharp", ctypes.c_int),
                ("most", _double),
                *_pointers("plan plan_user stage"), ("feature_angle", _double), ("distance", _double),
                ("rounds", ctypes.c_int), ("improve", _ImproveOptions)]


class _Hole(ctypes.Structure):
    """pbw_solid_hole."""
    _fields_ = [("edges", _size), ("length", _double), ("place", _double * 3), ("closed", ctypes.c_int)]


class _Boundary(ctypes.Structure):
    """pbw_solid_boundary."""
    _fields_ = [*((name, _size) for name in ("facet_count", "edge_count", "hole_count")),
                *_pointers("facets corners patches parts sides edges holes memory")]


_SHARP = ("auto", "all", "some", "none")          # as PBW_SOLID_SHARP_...
_AT_POINT = ctypes.CFUNCTYPE(_double, ctypes.c_void_p, ctypes.POINTER(_double))


class _SolidReport(ctypes.Structure):
    """pbw_solid_report."""
    _fields_ = [*((name, _size) for name in ("open_edges", "crowded_edges", "doubles", "shells", "holes")),
                ("hole", _Hole * 8),
                *((name, _double) for name in ("hole_share", "thickness", "estimate")),
                ("crossings", _size), ("crossing_place", _double * 3),
                ("closing_crossings", _size), *((name, ctypes.c_int) for name in ("united", "refusal")),
                ("regions", _size), ("sharp", ctypes.c_int), ("sharp_share", _double),
                *((name, _size) for name in ("corners", "sharp_edges", "acute_edges")),
                ("least_angle", _double), *((name, _size) for name in ("missing_edges", "bad_edges", "bad_points")),
                ("places", _double * 3 * 8),
                ("facets", _size),
                ("euler", ctypes.c_long), ("input_euler", ctypes.c_long), ("distance", _double), ("size", _double),
                ("input_volume", _double), ("rounds", ctypes.c_int), ("settled", ctypes.c_int),
                ("seconds", _double * 4), ("improve", _ImproveReport)]


class _FillInput(ctypes.Structure):
    """pbw_fill_input."""
    _fields_ = [("points", ctypes.c_void_p), ("point_count", _size), ("triangles", ctypes.c_void_p),
                ("triangle_count", _size), *_pointers("numbers segments"), ("segment_count", _size),
                *_pointers("seeds seed_regions"), ("seed_count", _size)]


class _FillOptions(ctypes.Structure):
    """pbw_fill_options."""
    _fields_ = [*((name, ctypes.c_int) for name in ("conforming", "split_flat", "nested", "outside")),
                ("most", _size), ("size", _double), *_pointers("size_at size_user"), ("growth", _double),
                ("ratio", _double), ("volume", _double), *_pointers("volumes"), ("volume_count", _size),
                ("improve", _ImproveOptions), *_pointers("stage")]


class _FillReport(ctypes.Structure):
    """pbw_fill_report."""
    _fields_ = [("refusal", ctypes.c_int), ("fault_count", _size), ("faults", ctypes.c_uint32 * 2 * 8),
                *((name, _size) for name in ("doubles", "collapsed", "segments", "facets", "missing_segments",
                                             "missing_facets", "segment_points", "inner_points", "inside_points",
                                             "too_large", "too_slim", "regions", "flat_tets")),
                ("improve", _ImproveReport), ("inner", _Quality), ("seconds", _double * 10)]


class _Filled(ctypes.Structure):
    """pbw_filled."""
    _fields_ = [("tets", _Mesh), ("facet_count", _size),
                *_pointers("facets facet_triangle facet_corners sides memory")]


_fit(_library, 8, _Mesh, _Quality, _ImproveOptions, _ImproveReport, _SolidInput, _SolidOptions, _SolidReport,
     _Boundary)
_fit(_library, 21, _FillInput, _FillOptions, _FillReport, _Filled)
_library.pbw_fill_refusal.restype = ctypes.c_char_p


class Tets:
    """Tetrahedra, and what they belong to.

    points (n, 3); tets (m, 4), positive; regions, one a tetrahedron; neighbors (m, 4), -1 on the boundary; original:
    per point its number in the input, -1 if it is new.
    facets (k, 3): of the boundary, between regions and of patches inside, once each, turned out of the first of their
    two sides (k, 2), which are regions; patches, one a facet.
    edges (e, 2): those that improve was given, or the sharp edges of a solid and those between its patches;
    edge_groups, one an edge, None without any.
    Regions, patches and edge groups are the caller's whole numbers or names, -1 or "" where there is none.
    report: a dictionary, in which before and after have dihedral angles in degrees.
    """

    def __init__(self, mesh, report):
        tets = (mesh.tet_count, 4)
        self.points = _copied(mesh.points, (mesh.point_count, 3), np.float64)
        self.tets = _copied(mesh.corners, tets, np.int32)
        self.regions = _copied(mesh.regions, mesh.tet_count, np.uint32)
        self.neighbors = _copied(mesh.neighbors, tets, np.int32)
        self.original = _copied(mesh.original, mesh.point_count, np.int32)
        self.edge_groups = None
        self.report = _plain(report)

    def __repr__(self):
        if self.report.get("inner") and self.report["improve"]["after"]["volume"] == 0:      # of fill, not improved
            return "<pbw.Tets: %d tetrahedra, %d points>" % (len(self.tets), len(self.points))
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


def _rows(pointer, count, columns):
    """A copy of rows of points of the library's; there may be none."""
    return _copied(pointer, (count, columns), np.int32) if count else np.empty((0, columns), np.int32)


def _labels(name, labels, count):
    """Whole numbers or names as numbers from 0, and the table of what these stand for; its last is for none."""
    labels = np.asarray(labels)
    if labels.shape != (count,):
        raise ValueError("%s has the shape %s: %d numbers or names are needed" % (name, labels.shape, count))
    if labels.dtype.kind == "f" and (labels == np.floor(labels)).all():
        labels = labels.astype(np.int64)
    if labels.dtype.kind == "O" and all(isinstance(one, str) for one in labels):
        labels = labels.astype(str)
    if count and labels.dtype.kind not in "iuU":
        raise ValueError("%s must be whole numbers or names" % name)
    table, numbers = np.unique(labels, return_inverse=True)
    table = np.append(table, "") if labels.dtype.kind == "U" else np.append(table.astype(np.int64), -1)
    return table, np.ascontiguousarray(numbers.reshape(-1), dtype=np.uint32)


def _places(name, given, rows, numbers):
    """Of each given row of points the place of the first of rows that has the same."""
    points = np.sort(np.concatenate([rows, given]), axis=1)
    order = np.lexsort(points.T)
    row = np.empty(len(points), np.int64)
    row[order] = np.concatenate([[0], np.cumsum((points[order[1:]] != points[order[:-1]]).any(axis=1))])
    first = np.full(len(points), -1)
    first[row[:len(rows)][::-1]] = np.arange(len(rows))[::-1]
    place = first[row[len(rows):]]
    if (place < 0).any():
        raise ValueError("%s[%d] is not in any tetrahedron" % (name, np.argmin(place)))
    number = np.empty(len(rows), np.uint32)
    number[place] = numbers
    if (number[place] != numbers).any():
        raise ValueError("%s[%d] is there again, and not in the same %s"
                         % (name, np.argmax(number[place] != numbers), "patch" if name == "facets" else "group"))
    return place


_OUTWARD = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])      # the facet across from each corner


def _take_facets(made, patches, patch_table, region_table):
    """Lists the facets of a Tets; patches: one a corner, of the facet across from it, -1: none."""
    beyond = made.neighbors.astype(np.int64)
    there = made.regions.astype(np.int64)
    other = np.where(beyond < 0, -1, there[beyond])
    corner = np.flatnonzero((beyond < 0) | ((np.arange(len(made.tets))[:, None] < beyond)
                                            & ((there[:, None] != other) | (patches >= 0))))
    made.facets = made.tets[corner[:, None] // 4, _OUTWARD[corner % 4]]
    made.patches = patch_table[patches.reshape(-1)[corner]]
    made.sides = region_table[np.stack([there[corner // 4], other.reshape(-1)[corner]], axis=1)]
    made.regions = region_table[there]


def _made(call, report, finish=lambda made, mesh: None, mesh=None):
    """A status and the Tets that call(watch, mesh, report) makes, in a thread; None if it fails.  finish(Tets, mesh)
    takes what else the mesh has."""
    mesh, stop, thrown = mesh or _Mesh(), ctypes.c_int(), []
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
        made = Tets(mesh, report)
        finish(made, mesh)
        return 0, made
    finally:
        _library.pbw_tets_free(ctypes.byref(mesh))


def _check_number(name, value, least, most):
    if not least <= value <= most:
        raise ValueError("%s must be from %g to %g, not %r" % (name, least, most, value))


_SMOOTHERS = "odt", "lloyd", "laplace"


def improve(points, tets, target=30, seconds=0, feature_angle=40, regions=None, fixed=None, smooth=None, rounds=5,
            facets=None, patches=None, edges=None, edge_groups=None, sizes=None):
    """Tetrahedra with better dihedral angles: from target to 180 - target degrees, where that can be had.

    points: (n, 3); tets: (m, 4); seconds: ends after that time, 0 = when nothing helps any more; fixed: n booleans,
    True for points that stay; sizes: n lengths that edges shall have there; smooth: before the rest, so many rounds
    move points to better means, "odt", "lloyd" or "laplace"; target None: nothing else.

    Regions, patches and edge groups are whole numbers or names, and come out as they went in:
    regions: m of them; where two meet, the interface is kept.
    facets: (k, 3), patches: k of them, default 0: facets of tetrahedra, on the boundary or inside.  Where two patches
    meet, the edges are kept; facets inside stay as they are.
    edges: (e, 2), edge_groups: e of them: edges of tetrahedra that stay; with sizes they may get points.

    The parts of a meshio mesh, or of a Tets that solid made, fit: regions=made.regions, facets=made.facets,
    patches=made.patches, edges=made.edges.  Returns a Tets.
    """
    points = _checked("points", points, 3, np.float64)
    tets = _checked("tets", tets, 4, np.uint32, len(points))
    for name, of, array in ("patches", "facets", facets), ("edge_groups", "edges", edges):
        if array is None and (patches if name == "patches" else edge_groups) is not None:
            raise ValueError("%s needs %s" % (name, of))
    facets = _checked("facets", np.empty((0, 3), int) if facets is None else facets, 3, np.uint32, len(points))
    edges = _checked("edges", np.empty((0, 2), int) if edges is None else edges, 2, np.uint32, len(points))
    marks = None if fixed is None else np.where(np.asarray(fixed, bool), 2, 0).astype(np.uint8)
    sizes = None if sizes is None else np.ascontiguousarray(sizes, dtype=np.float64)
    for name, array in ("fixed", marks), ("sizes", sizes):
        if array is not None and array.shape != (len(points),):
            raise ValueError("%s has the shape %s: %d numbers are needed" % (name, array.shape, len(points)))
    region_table, region = _labels("regions", np.zeros(len(tets), int) if regions is None else regions, len(tets))
    patch_table, patch = _labels("patches", np.zeros(len(facets), int) if patches is None else patches, len(facets))
    group_table, group = _labels("edge_groups", np.zeros(len(edges), int) if edge_groups is None else edge_groups,
                                 len(edges))
    across = np.full(4 * len(tets), 0xffffffff, np.uint32)
    if len(facets):
        across[_places("facets", facets, tets[:, _OUTWARD].reshape(-1, 3), patch)] = patch
    if len(edges):
        pairs = np.array(list(itertools.combinations(range(4), 2)))
        _places("edges", edges, tets[:, pairs].reshape(-1, 2), group)
    if smooth is not None and smooth not in _SMOOTHERS:
        raise ValueError("smooth is %r: one of %s is needed" % (smooth, ", ".join(_SMOOTHERS)))
    if target is not None:
        _check_number("target", target, 1, 60)
    given = _Mesh(len(points), len(tets), points.ctypes.data, tets.ctypes.data, region.ctypes.data,
                  None if marks is None else marks.ctypes.data)
    given.patches = across.ctypes.data
    given.edges, given.edge_count = edges.ctypes.data, len(edges)
    how = _ImproveOptions(target or 0, seconds, -1 if target is None else 0, feature_angle)
    how.sizes = None if sizes is None else sizes.ctypes.data
    if smooth is not None:
        how.rounds, how.smoother = rounds, _SMOOTHERS.index(smooth)
    message = ctypes.create_string_buffer(128)

    def finish(made, mesh):
        _take_facets(made, _copied(mesh.patches, (mesh.tet_count, 4), np.int32), patch_table, region_table)
        made.edges = _rows(mesh.edges, mesh.edge_count, 2)
        if edge_groups is not None:
            made.edge_groups = group_table[group[_rows(mesh.edge_origins, mesh.edge_count, 1)[:, 0]]]

    status, made = _made(lambda watch, mesh, report: _library.pbw_python_improve(
        ctypes.byref(given), ctypes.byref(how), watch, message, mesh, report), _ImproveReport(), finish)
    if status:
        text = message.value.decode() or _library.pbw_status_string(status).decode()
        raise _errors.from_status(status, text, points, None)
    return made


def _at_points(function, thrown):
    """Returns the C callback that calls a function of a point (x, y, z); what it raises goes to thrown."""
    def at(user, point):
        try:
            return float(function((point[0], point[1], point[2])))
        except BaseException as e:
            thrown.append(e)
            return np.inf
    return _AT_POINT(at)


def _longest(size, vertices):
    """Returns the largest size at the vertices and in their box; infinite ones are 1/40 of its diagonal."""
    if len(vertices) == 0 or not np.isfinite(vertices).all():
        return 0
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    grid = itertools.product(*(np.linspace(low[k], high[k], 9).tolist() for k in range(3)))
    sizes = np.array([float(size(tuple(place))) for place in itertools.chain(vertices.tolist(), grid)])
    longest = np.where(np.isfinite(sizes), sizes, np.linalg.norm(high - low) / 40).max()
    if not longest > 0:
        raise ValueError("size is above 0 nowhere in the box of the vertices")
    return longest


def solid(vertices, faces, size=0, target=30, feature_angle=40, rounds=0, patches=None, nested=False,
          least_size=0, curvature=0, sharp="auto", close=False, most=50e6, around=0, gradation=0,
          wrap=False, region_sizes=None):
    """Tetrahedra inside a closed surface: vertices (n, 3), faces (m, 3), one or several shells.

    size: length of edges, 0 = 1/40 of the diagonal, or a function of a point (x, y, z).  Of that the largest value at
    the vertices and at 729 places in their box is the longest edge; infinite ones count as 1/40 of the diagonal.
    They are shorter in thin walls, and with curvature=c at most c radii of curvature, but not below least_size;
    around=n, edges around a circle, is curvature=2 pi / n.  They grow by at most gradation, 0 = 0.35, for each unit
    of length.  region_sizes, {number: length}: the same in regions of these numbers.
    rounds of adding points, at most; 0 = 16, or 24 where tips need them.
    Edges of the surface that bend by more than feature_angle degrees are kept, and those between faces of different
    patches, a whole number or a name a face.  sharp: which of the edges that bend are kept, "all", "some", "none" or
    "auto".
    nested=True: shells inside of others bound regions, else every second is a cavity, and shells that cross are one
    body.
    Surfaces that are mostly holes or very thin are refused, unless close=True, and more than `most` tetrahedra.

    wrap=True fills a wrap of the faces instead, which may have holes, crossings and gaps: size, a number, target and
    most are as else, the other arguments have no effect.  Sharp edges are rounded off by about half the size; holes
    are closed up to that, and up to 1.5 times that where it closes the model; sheets become plates, 1/4 of the size
    thick.  If the faces are closed, points are pulled onto them as far as it keeps tetrahedra good.  The report is
    that of improve, and in it "wrap" is that of pbw.wrap, "distance" how far the boundary is from the faces and the
    faces from the boundary, at most, "distance_before" the same of the wrap, "raised" the alpha that left the model
    open, if a larger one was taken, "closed" whether the faces are, and "size".

    Returns a Tets.  Its regions are numbers of shells, its patches those given, else numbers of the parts between
    sharp edges, and -1 or "" where a hole is closed; parts are the latter numbers in any case.  Its report has
    bad_edges, bad_points, missing_edges and open_edges, all 0 if the boundary is a manifold on the surface, and the
    largest holes.
    """
    vertices = _checked("vertices", vertices, 3, np.float64)
    faces = _checked("faces", faces, 3, np.uint32, len(vertices))
    given = _SolidInput(vertices.ctypes.data, len(vertices), faces.ctypes.data, len(faces))
    if patches is not None:
        table, patches = _labels("patches", patches, len(faces))
        given.patches = patches.ctypes.data
    for name, value in (("size", size), ("least_size", least_size), ("curvature", curvature), ("around", around),
                        ("gradation", gradation)):
        if not callable(value):
            _check_number(name, value, 0, np.finfo(float).max)
    if target > 0:
        _check_number("target", target, 1, 60)
    if sharp not in _SHARP:
        raise ValueError("sharp must be one of " + ", ".join(_SHARP))
    _check_number("most", most, 1, np.finfo(float).max)
    longest = _longest(size, vertices) if callable(size) else size
    if around > 0:
        curvature = min(curvature or np.inf, 2 * np.pi / around)
    regions = np.zeros(max(region_sizes or {-1: 0}) + 1)
    for number, length in (region_sizes or {}).items():
        _check_number("the number of a region", number, 0, 1e6)
        _check_number("the size of a region", length, 0, np.finfo(float).max)
        regions[number] = length
    how = _SolidOptions(longest, least_size, None, None, regions.ctypes.data, len(regions), curvature, gradation,
                        nested, close, _SHARP.index(sharp), most, None, None, None, feature_angle, 0, rounds,
                        _ImproveOptions(target))
    if wrap:
        if callable(size):
            raise ValueError("size must be a number with wrap=True")
        from ._wrap import _filled
        return _filled(vertices, faces, size, target, most)
    thrown = []
    if callable(size):
        keep = _at_points(size, thrown)
        how.size_at = ctypes.cast(keep, ctypes.c_void_p)
    boundary = _Boundary()

    def finish(made, mesh):
        made.facets = _copied(boundary.facets, (boundary.facet_count, 3), np.int32)
        made.patches = _copied(boundary.patches, boundary.facet_count, np.int32)
        if patches is not None:
            made.patches = table[made.patches]
        made.parts = _copied(boundary.parts, boundary.facet_count, np.int32)
        made.sides = _copied(boundary.sides, (boundary.facet_count, 2), np.int32)
        made.edges = _rows(boundary.edges, boundary.edge_count, 2)

    try:
        status, made = _made(lambda watch, mesh, report: _library.pbw_python_solid(
            ctypes.byref(given), ctypes.byref(how), watch, mesh, ctypes.byref(boundary), report), _SolidReport(),
                             finish)
    finally:
        _library.pbw_solid_boundary_free(ctypes.byref(boundary))
    if thrown:
        raise thrown[0]
    if status == _errors.DEGENERATE:
        raise _errors.Error("nothing is inside of the surface: it is an open sheet, or mostly holes, which "
                            "close=True closes, or thinner than the size")
    if status:
        raise _errors.from_status(status, _library.pbw_status_string(status).decode(), vertices, None)
    return made


def fill(vertices, faces, numbers=None, segments=None, seeds=None, seed_regions=None, conforming=False,
         split_flat=False, nested=False, outside=False, target=None, seconds=0, most=50000000, size=0, gradation=0,
         ratio=0, volume=0):
    """Tetrahedra that keep a surface's own triangles: vertices (n, 3), faces (m, 3), with holes or walls as you like.

    The facets are the faces; report["refusal"] is not 0 if points had to stay on edges.  With conforming=True points
    may stay, and each flat part of the surface, with split_flat=True each face, is a union of facets.
    numbers: a whole number or a name a face; flat parts do not cross between two of them.
    segments (s, 2): edges that belong to no face.  Vertices of no face are kept where they are inside.
    seeds (k, 3): places in regions; seed_regions, their whole numbers, -1 = a hole.  Else what is inside of an odd
    number of shells is kept, with nested=True all that is enclosed, and with outside=True a box around it, too.
    Points inside, if one of these is given; at faces tetrahedra may be larger or slimmer, see report["too_large"] and
    report["too_slim"]: size, the length of edges, a number or a function of a point (x, y, z), else that of the
    faces' edges, which grows by gradation (0.3) a unit of distance; ratio (2), of circumscribed radius by shortest
    edge; volume of a tetrahedron, a number or a dictionary with one for each of seed_regions that has a bound.
    target: degrees, dihedral angles inside are raised to it as far as the faces let it, in `seconds` if not 0.
    seed_regions may be names, "" = a hole; then the regions are names, too, and "" where no seed is.

    Returns a Tets.  Its patches are the face that has each facet, or with numbers its number.
    Raises pbw.Error with the reason where faces cross, have no area, or bound nothing.
    """
    vertices = _checked("vertices", vertices, 3, np.float64)
    faces = _checked("faces", faces, 3, np.uint32, len(vertices))
    given, names = _FillInput(vertices.ctypes.data, len(vertices), faces.ctypes.data, len(faces)), None
    if numbers is not None:
        table, numbers = _labels("numbers", numbers, len(faces))
        given.numbers = numbers.ctypes.data
    if segments is not None:
        segments = _checked("segments", segments, 2, np.uint32, len(vertices))
        given.segments, given.segment_count = segments.ctypes.data, len(segments)
    if seeds is not None:
        seeds = _checked("seeds", seeds, 3, np.float64)
        given.seeds, given.seed_count = seeds.ctypes.data, len(seeds)
    if seed_regions is not None:
        seed_regions = np.asarray(seed_regions)
        if seeds is None or seed_regions.shape != (len(seeds),):
            raise ValueError("seed_regions must have one number a seed")
        if seed_regions.dtype.kind == "U":
            names = np.array([*np.unique(seed_regions[seed_regions != ""]), ""])
            seed_regions = np.where(seed_regions == "", -1, np.searchsorted(names[:-1], seed_regions))
        seed_regions = np.ascontiguousarray(seed_regions, np.int32)
        given.seed_regions = seed_regions.ctypes.data
    _check_number("most", most, 1, 2**32)
    if target is not None:
        _check_number("target", target, 1, 60)
    how = _FillOptions(conforming, split_flat, nested, outside, int(most))
    how.improve = _ImproveOptions(target or 0, seconds)
    for name, value in ("gradation", gradation), ("ratio", ratio):
        _check_number(name, value, 0, np.finfo(float).max)
    if gradation and (callable(size) or size or not (ratio or volume)):
        raise ValueError("gradation is for ratio or volume without size")
    how.growth, how.ratio, thrown = gradation, ratio, []
    if callable(size):
        keep = _at_points(size, thrown)
        how.size_at = ctypes.cast(keep, ctypes.c_void_p)
    else:
        _check_number("size", size, 0, np.finfo(float).max)
        how.size = size
    if isinstance(volume, dict):
        numbers_of = {name: i for i, name in enumerate(names[:-1].tolist())} if names is not None else None
        keys = [one if numbers_of is None else numbers_of.get(one, -1) for one in volume]
        if seed_regions is None or not set(keys) <= set(seed_regions.tolist()) or -1 in keys:
            raise ValueError("volume: its keys must be among seed_regions")
        bounds = np.zeros(max(keys, default=0) + 1)
        bounds[keys] = list(volume.values())
        how.volumes, how.volume_count = bounds.ctypes.data, len(bounds)
    else:
        _check_number("volume", volume, 0, np.finfo(float).max)
        how.volume = volume
    filled, report = _Filled(), _FillReport()

    def finish(made, mesh):
        made.facets = _copied(filled.facets, (filled.facet_count, 3), np.int32)
        made.facet_triangle = _copied(filled.facet_triangle, filled.facet_count, np.int32)
        made.patches = made.facet_triangle if numbers is None else table[numbers[made.facet_triangle]]
        made.sides = _copied(filled.sides, (filled.facet_count, 2), np.int32)
        made.edges = np.empty((0, 2), np.int32)
        if names is not None:
            made.regions = names[np.minimum(made.regions, len(names) - 1)]

    try:
        status, made = _made(lambda watch, mesh, report: _library.pbw_python_fill(
            ctypes.byref(given), ctypes.byref(how), watch, ctypes.byref(filled), report), report, finish, filled.tets)
    finally:
        _library.pbw_fill_free(ctypes.byref(filled))
    if thrown:
        raise thrown[0]
    if status == _errors.DEGENERATE:
        faults = [[int(one) for one in pair if one != 2**32 - 1] for pair in report.faults[:report.fault_count]]
        raise _errors.Error(_library.pbw_fill_refusal(report.refusal).decode() + (": %s" % faults if faults else ""))
    if status:
        raise _errors.from_status(status, _library.pbw_status_string(status).decode(), vertices, None)
    return made
