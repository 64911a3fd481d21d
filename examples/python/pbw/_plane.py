"""Plane domains: the functions triangulate, with the dictionaries of the package triangle, and polygon."""
import re

import numpy as np

from . import _library
from ._arguments import check_options, checked_points

SPLIT, REFINE, KEEP_BOUNDARY, KEEP_SEGMENTS, CONFORMING = 1, 2, 4, 8, 16        # of PBW_PLANE_*
HULL, SEEDS, EVEN_ODD, NONZERO = range(4)


def _switches(options):
    """The switches of Triangle as a dictionary: letter (YY for the second Y) to its number or None."""
    found = {}
    for match in re.finditer(r"(YY|[A-Za-z])([0-9.eE+-]*[0-9.])?|(.)", options):
        letter, number, other = match.groups()
        if other or letter not in "p q a c D Y YY S j A e n z Q V B P I".split():
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


def triangulate(data, options="", *, split_crossings=False, threads=0):
    """Triangulates and refines a plane domain, with the dictionaries and switches of the package triangle.

    data       vertices; and, for the switch p, segments, holes, regions (x, y, attribute, largest area each);
               segment_markers if there are some
    options    p segments, q30 least angle (20 if there is no number), a0.1 largest area (of regions if there is no
               number), c convex hull, D conforming, Y and YY no points on the boundary and on segments, S100 at most
               so many points, j unused vertices left out, A attributes of regions, e edges, n neighbors
    Returns a dictionary: vertices, vertex_markers (1: on a segment or the boundary), triangles; with p segments and
    segment_markers; with A triangle_attributes, with e edges, with n neighbors.
    """
    given = _switches(options)
    if "vertices" not in data:
        raise ValueError("data must have vertices; it has %s" % (", ".join(map(repr, data)) or "nothing"))
    points = checked_points(data["vertices"])
    if points.shape[1] != 2:
        raise ValueError("vertices must be in 2D, not in %dD" % points.shape[1])
    check_options(False, None, threads)
    with_segments = "p" in given
    part = data if with_segments else {}
    segments = _checked(part, "segments", 2, np.int64, len(points)).astype(np.uint32)
    holes = _checked(part, "holes", 2, np.float64)
    regions = _checked(part, "regions", 4, np.float64)
    areas = regions[:, [0, 1, 3]].copy()
    if "a" not in given or given["a"] is not None:
        areas[:, 2] = 0
    flags = (SPLIT * bool(split_crossings) | REFINE * bool({"q", "a", "D"} & set(given))
             | KEEP_BOUNDARY * ("Y" in given) | KEEP_SEGMENTS * ("YY" in given) | CONFORMING * ("D" in given))
    angle = (given["q"] or 20) if "q" in given else -1
    made = _library.plane(points, segments, holes, np.maximum(areas, [-np.inf, -np.inf, 0]), threads=threads,
                          flags=flags, rule=SEEDS if with_segments and "c" not in given else HULL, angle=angle,
                          area=given.get("a") or 0, steiner_limit=int(given.get("S") or 0))
    return _dictionary(made, data, given, regions)


def _dictionary(made, data, given, regions):
    points, triangles, edges = made["points"], made["triangles"], made["edges"]
    if "j" in given:
        used = np.unique(triangles)
        number = np.full(len(points), -1, np.int32)
        number[used] = np.arange(len(used), dtype=np.int32)
        points, triangles, edges = points[used], number[triangles], number[edges]
    markers = np.zeros((len(points), 1), np.int32)
    markers[edges] = 1
    out = {"vertices": points, "vertex_markers": markers, "triangles": triangles}
    if "p" in given:
        of_segments = np.array(data.get("segment_markers", np.empty(0)), np.int32).reshape(-1)
        first = made["edge_first"]
        own = first[:-1] < first[1:]
        of_edges = np.ones(len(edges), np.int32)
        if len(of_segments):
            of_edges[own] = of_segments[made["edge_segments"][first[:-1][own]]]
        out["segments"], out["segment_markers"] = edges, of_edges.reshape(-1, 1)
    if "A" in given:
        seeds = made["region_seeds"][made["regions"]]
        attributes = np.append(regions[:, 2], 0.0)
        out["triangle_attributes"] = attributes[np.where(seeds < 0, len(regions), seeds)].reshape(-1, 1)
    if "e" in given:
        pairs = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        out["edges"] = np.unique(pairs, axis=0)
    if "n" in given:
        out["neighbors"] = made["neighbors"]
    return out


def polygon(rings, *, split_crossings=False, threads=0):
    """Triangles of a polygon: rings of points, of which holes are some, in any order and direction, by the even-odd
    rule.  Returns vertices, those of the rings one after the other (and crossings behind them), and triangles."""
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
    return made["points"], made["triangles"]
