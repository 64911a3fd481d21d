"""Plane domains: the functions triangulate, with the dictionaries of the package triangle, and polygon."""
import re

import numpy as np

from . import _errors, _library
from ._arguments import check_options, checked_points

SPLIT, REFINE, KEEP_BOUNDARY, KEEP_SEGMENTS, CONFORMING = 1, 2, 4, 8, 16        # of PBW_PLANE_*
HULL, SEEDS, EVEN_ODD, NONZERO = range(4)
WAYS = "laplace", "lloyd", "odt"                                                # of pbw_plane_way


def _switches(options):
    """The switches of Triangle as a dictionary: letter (YY for the second Y) to its number or None."""
    found = {}
    for match in re.finditer(r"(YY|[A-Za-z])([0-9.eE+-]*[0-9.])?|(.)", options):
        letter, number, other = match.groups()
        if other or letter not in "p r q a c D Y YY S j A e n z Q V B P I".split():
            raise ValueError("options=%r: %r is no switch that is known here" % (options, other or letter))
        if number and letter not in "qaS":
            raise ValueError("options=%r: %s takes no number" % (options, letter))
        found[letter] = float(number) if number else None
    return found


def _checked(data, name, columns, kind, count=None):
    """The member of a dictionary as an array of so many columns; empty if it is not there."""
    array = np.array(data.get(name, np.empty((0, columns))), dtype=kind, order="C")
    if array.ndim != 2 or array.shape[1] != columns:
        raise ValueError("%s must have %d columns, not the shape %s" % (name, columns, array.shape))
    if count is not None and array.size and not (array.min() >= 0 and array.max() < count):
        raise ValueError("%s must be from 0 to %d, the last vertex" % (name, count - 1))
    return array


def triangulate(data, options="", *, split_crossings=False, most=50e6, smooth=None, rounds=5, threads=0):
    """Triangulates and refines a plane domain, with the dictionaries and switches of the package triangle.

    data       vertices, with vertex_attributes and vertex_markers if there are some; and, for the switch p, segments,
               with segment_markers, holes, regions (x, y, attribute, largest area each); for r triangles, turned in
               any way, with triangle_attributes, segments and segment_markers
    options    p segments, r triangles: what they cover is the domain, edges between triangles of different
               attributes stay, and so do the segments; q30 least angle (20 if there is no number), a0.1 largest area
               (of regions if there is no number), c convex hull, D conforming, Y and YY no points on the boundary and
               on segments, S100 at most so many points, j unused vertices left out, A attributes of regions, e edges,
               n neighbors
    smooth     "laplace", "lloyd" or "odt": then vertices on no segment move to better places, `rounds` times
    Returns a dictionary: vertices, vertex_markers, triangles; vertex_attributes if data has them, linear in the
    triangles of the domain, with r in those of data, at vertices that are new or have moved; with p or r segments and
    segment_markers; with A triangle_attributes, and with r if data has them; with e edges, with n neighbors.  A
    marker of a vertex is its own; else that of the first of its segments that has one; else 1 on the boundary, or 0.
    If data has no markers, all on segments have 1.  Raises pbw.Error if nothing is enclosed; ValueError for more than
    `most` triangles of refinement, before work if areas ask for them.
    """
    given = _switches(options)
    if "vertices" not in data:
        raise ValueError("data must have vertices; it has %s" % (", ".join(map(repr, data)) or "nothing"))
    points = checked_points(data["vertices"])
    if points.shape[1] != 2:
        raise ValueError("vertices must be in 2D, not in %dD" % points.shape[1])
    check_options(False, None, threads)
    if not most > 0:
        raise ValueError("most must be above 0, not %r" % (most,))
    if smooth not in (None, *WAYS):
        raise ValueError("smooth must be None, %s, not %r" % (" or ".join(map(repr, WAYS)), smooth))
    triangles, of_triangles, kinds = _mesh_of(data, len(points)) if "r" in given else (None, None, None)
    with_segments = "p" in given
    part = data if with_segments or "r" in given else {}
    segments = _checked(part, "segments", 2, np.int64, len(points)).astype(np.uint32)
    holes = _checked(part, "holes", 2, np.float64)
    regions = _checked(part, "regions", 4, np.float64)
    areas = regions[:, [0, 1, 3]].copy()
    if "a" not in given or given["a"] is not None:
        areas[:, 2] = 0
    flags = (SPLIT * bool(split_crossings) | REFINE * bool({"q", "a", "D"} & set(given))
             | KEEP_BOUNDARY * ("Y" in given) | KEEP_SEGMENTS * ("YY" in given) | CONFORMING * ("D" in given))
    angle = (given["q"] or 20) if "q" in given else -1
    attributes = _of_items(data, "vertex_attributes", np.float64, len(points))
    markers = _of_items(data, "vertex_markers", np.int32, len(points), 1)
    of_segments = _of_items(part, "segment_markers", np.int32, len(segments), 1)
    made = _library.plane(points, segments, holes, np.maximum(areas, [-np.inf, -np.inf, 0]), triangles, of_triangles,
                          way=WAYS.index(smooth) if smooth else 0, rounds=rounds if smooth else 0, threads=threads,
                          flags=flags, rule=SEEDS if with_segments and "c" not in given else HULL, angle=angle,
                          area=given.get("a") or 0, steiner_limit=int(given.get("S") or 0), most=most)
    if not len(made["triangles"]):
        raise _nothing_enclosed(points, segments, flags & SPLIT)
    if attributes is not None:
        attributes = _interpolated(attributes, points, segments, made["points"], flags & SPLIT, triangles)
    return _dictionary(made, given, regions, attributes, markers, of_segments, kinds)


def _mesh_of(data, count):
    """Triangles, a number of each one's attributes or None, and the attributes of each number or None."""
    triangles = _checked(data, "triangles", 3, np.int64, count).astype(np.uint32)
    if not len(triangles):
        raise ValueError("the switch r needs triangles; data has none")
    attributes = _of_items(data, "triangle_attributes", np.float64, len(triangles))
    if attributes is None:
        return triangles, None, None
    kinds, numbers = np.unique(attributes, axis=0, return_inverse=True)
    return triangles, np.ascontiguousarray(numbers.reshape(-1), np.uint32), kinds


def _of_items(data, name, kind, count, columns=None):
    """The member of a dictionary with a row for each item, or None; columns: how many there are, else any number."""
    if data.get(name) is None:
        return None
    array = np.array(data[name], dtype=kind, order="C")
    array = array.reshape(-1, 1) if array.ndim == 1 else array
    if array.ndim != 2 or len(array) != count or columns not in (None, array.shape[1]):
        raise ValueError("%s must have %d rows%s, not the shape %s"
                         % (name, count, "" if columns is None else " of %d number" % columns, array.shape))
    return array


def _whole(points, segments, split):
    """The triangulation of a domain's points and segments, up to the hull."""
    none = np.empty((0, 3))
    return _library.plane(points, segments, none[:, :2].copy(), none, threads=0, flags=split, rule=HULL, angle=-1,
                          area=0, steiner_limit=0)


def _nothing_enclosed(points, segments, split):
    if not len(segments):
        return _errors.Error("nothing is enclosed, there are no segments: leave out the switch p, or add c")
    whole = _whole(points, segments, split)
    own = whole["edge_first"][:-1] < whole["edge_first"][1:]
    vertices, uses = np.unique(whole["edges"][own], return_counts=True)
    ends = ["vertex %d (%.9g, %.9g)" % (v, *whole["points"][v]) for v in vertices[uses == 1]]
    if not ends:
        return _errors.Error("nothing is enclosed: holes, or rings that lie on each other, take all; the switch c "
                             "triangulates all")
    return _errors.Error("nothing is enclosed: segments end where no other goes on, at %s%s; close the outline, or "
                         "the switch c triangulates all"
                         % (", ".join(ends[:4]), " and so on" if len(ends) > 4 else ""))


def _interpolated(attributes, points, segments, places, split, triangles):
    """Attributes at places: given ones at the points, which come first, unless they have moved; else linear in the
    triangles, those of the domain if there are none."""
    same = (places[:len(points)] == points).all(axis=1)
    if len(places) == len(points) and same.all():
        return attributes
    if triangles is not None:
        a, b, c = points[triangles.T]
        turned = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) < (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
        triangles = np.where(turned[:, None], triangles[:, ::-1], triangles)
        out = _library.transfer(points, np.ascontiguousarray(triangles), np.ascontiguousarray(attributes), places)
        out[:len(points)][same] = attributes[same]
        return out
    whole = _whole(points, segments, split)
    values = np.zeros((len(whole["points"]), attributes.shape[1]))
    values[:len(points)] = attributes
    if len(values) > len(points):                        # crossings: the mean of what their segments have there
        count = np.zeros(len(values))
        edge = np.repeat(np.arange(len(whole["edges"])), np.diff(whole["edge_first"]))
        a, b = segments[whole["edge_segments"]].T.astype(np.int64)
        for end in whole["edges"][edge].T:
            new = end >= len(points)
            to, start, along = end[new], points[a[new]], points[b[new]] - points[a[new]]
            share = (((whole["points"][to] - start) * along).sum(axis=1) / (along * along).sum(axis=1))[:, None]
            np.add.at(values, to, (1 - share) * attributes[a[new]] + share * attributes[b[new]])
            np.add.at(count, to, 1)
        values[len(points):] /= np.maximum(count[len(points):], 1)[:, None]
    out = _library.transfer(whole["points"], whole["triangles"], values, places)
    out[:len(points)][same] = attributes[same]
    return out


def _markers(made, markers, of_segments):
    """Markers of the edges and of the points."""
    edges, first = made["edges"], made["edge_first"]
    has_markers = any(m is not None and m.any() for m in (markers, of_segments))
    of_edges = np.zeros(len(edges), np.int32) if has_markers else np.ones(len(edges), np.int32)
    triangle, corner = np.nonzero(made["neighbors"] < 0)
    sides = np.sort(np.stack([made["triangles"][triangle, (corner + k) % 3] for k in (1, 2)], axis=1), axis=1)
    key = np.int64(len(made["points"]))
    of_edges[np.isin(np.sort(edges, axis=1) @ [key, 1], sides @ [key, 1])] = 1
    segment = np.full(len(edges), np.iinfo(np.int64).max)
    if of_segments is not None and len(made["edge_segments"]):
        edge = np.repeat(np.arange(len(edges)), np.diff(first))
        named = of_segments[made["edge_segments"], 0] != 0
        np.minimum.at(segment, edge[named], made["edge_segments"][named])
        own = segment < len(of_segments)
        of_edges[own] = of_segments[segment[own], 0]
    of_points = np.zeros(len(made["points"]), np.int32)
    order = np.argsort(-segment, kind="stable")          # the first segment writes last
    of_points[edges[order][of_edges[order] != 0]] = of_edges[order][of_edges[order] != 0, None]
    if markers is not None:
        given = np.flatnonzero(markers[:, 0])
        of_points[given] = markers[given, 0]
    return of_edges.reshape(-1, 1), of_points.reshape(-1, 1)


def _dictionary(made, given, regions, attributes, markers, of_segments, kinds):
    points, triangles, edges = made["points"], made["triangles"], made["edges"]
    of_edges, of_points = _markers(made, markers, of_segments)
    if "j" in given:
        used = np.unique(triangles)
        number = np.full(len(points), -1, np.int32)
        number[used] = np.arange(len(used), dtype=np.int32)
        points, triangles, edges, of_points = points[used], number[triangles], number[edges], of_points[used]
        attributes = None if attributes is None else attributes[used]
    out = {"vertices": points, "vertex_markers": of_points, "triangles": triangles}
    if attributes is not None:
        out["vertex_attributes"] = attributes
    if "p" in given or "r" in given:
        out["segments"], out["segment_markers"] = edges, of_edges
    if kinds is not None:
        out["triangle_attributes"] = kinds[made["region_seeds"][made["regions"]]]
    elif "A" in given:
        seeds = made["region_seeds"][made["regions"]]
        of_regions = np.append(regions[:, 2], 0.0)
        out["triangle_attributes"] = of_regions[np.where(seeds < 0, len(regions), seeds)].reshape(-1, 1)
    if "e" in given:
        pairs = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        out["edges"] = np.unique(pairs, axis=0)
    if "n" in given:
        out["neighbors"] = made["neighbors"]
    return out


def polygon(rings, *, split_crossings=False, threads=0):
    """Triangles of a polygon: rings of points, of which holes are some, in any order and direction, by the even-odd
    rule.  Returns vertices, those of the rings one after the other (and crossings behind them), and triangles.
    Raises pbw.Error if nothing is enclosed."""
    rings = [checked_points(ring) for ring in rings]
    check_options(False, None, threads)
    if not rings or any(ring.shape[1] != 2 for ring in rings):
        raise ValueError("rings must be arrays of points in 2D, one or more")
    points, start, segments = np.concatenate(rings), 0, []
    for ring in rings:
        here = np.arange(start, start + len(ring), dtype=np.uint32)
        segments.append(np.stack([here, np.roll(here, -1)], axis=1))
        start += len(ring)
    none = np.empty((0, 3))
    made = _library.plane(points, np.ascontiguousarray(np.concatenate(segments)), none[:, :2].copy(), none,
                          threads=threads, flags=SPLIT * bool(split_crossings), rule=EVEN_ODD, angle=-1, area=0,
                          steiner_limit=0)
    if not len(made["triangles"]):
        raise _errors.Error("nothing is enclosed: rings that lie on each other take all")
    return made["points"], made["triangles"]
