"""python.py: the package pbw against exact arithmetic, SciPy's documentation, and SciPy itself; see python.sh."""
import _thread
import copy
import doctest
import itertools
import os
import pickle
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import traceback
import types
import unittest.mock
from fractions import Fraction

import numpy as np

import pbw

try:
    import scipy.spatial
except ImportError:
    scipy = None

tests = []


class Skip(Exception):
    pass


def test(function):
    tests.append(function)
    return function


def with_scipy(function):
    function.needs_scipy = True
    return test(function)


def check(condition, *what):
    if not condition:
        raise AssertionError(*what)


def equal(a, b):
    check(np.array_equal(a, b), a, b)


def raises(kind, function, *arguments, **named):
    try:
        function(*arguments, **named)
    except kind as e:
        return e
    raise AssertionError("no %s" % kind.__name__)


def raises_text(kind, text, function, *arguments, **named):
    said = str(raises(kind, function, *arguments, **named))
    check(re.search(text, said), said)


def sets(rows):
    """Rows as a set of sorted tuples; none may be there twice."""
    result = {tuple(sorted(row)) for row in rows.tolist()}
    check(len(result) == len(rows), "twice")
    return result


def determinant(rows):
    if len(rows) == 1:
        return rows[0][0]
    return sum((-1) ** k * x * determinant([r[:k] + r[k + 1:] for r in rows[1:]]) for k, x in enumerate(rows[0]))


def orient(corners):
    p = [[Fraction(x) for x in corner] for corner in np.asarray(corners).tolist()]
    return determinant([[x - y for x, y in zip(q, p[0])] for q in p[1:]])


def conflict(corners, weights, q, w):
    """Positive if q with weight w is in conflict with a positively oriented simplex."""
    q = [Fraction(x) for x in np.asarray(q).tolist()]
    rows = []
    for corner, weight in zip(np.asarray(corners).tolist(), weights):
        r = [Fraction(x) - y for x, y in zip(corner, q)]
        rows.append(r + [sum(x * x for x in r) - Fraction(float(weight)) + Fraction(float(w))])
    return determinant(rows) * (1 if len(q) == 2 else -1)


def inputs(dim, count=60):
    """Points in general position, on a lattice, with duplicates, on a circle or sphere."""
    rng = np.random.default_rng(dim)
    lattice = np.array(list(itertools.product(range(4), repeat=dim)), float)
    yield rng.random((count, dim))
    yield lattice
    yield np.concatenate([lattice[::2], lattice[::3], lattice])
    sphere = [p for p in itertools.product(range(-5, 6), repeat=dim) if sum(x * x for x in p) in (25, 0)]
    yield np.array(sphere, float)
    yield np.ldexp(rng.random((count, dim)), rng.integers(-200, 0, (count, dim)))


def structure(tri):
    """Orientation, neighbours, one simplex for each point."""
    for t, (corners, neighbors) in enumerate(zip(tri.simplices.tolist(), tri.neighbors.tolist())):
        check(orient(tri.points[corners]) > 0)
        for k, n in enumerate(neighbors):
            if n >= 0:
                facet = set(corners[:k] + corners[k + 1:])
                check(facet == set(tri.simplices[n]) - {int(tri.simplices[n][list(tri.neighbors[n]).index(t)])})
    for p, t in enumerate(tri.vertex_to_simplex.tolist()):
        check(t < 0 or p in tri.simplices[t] or p in tri.coplanar[:, 0])


@test
def delaunay_in_exact_arithmetic():
    for dim in (2, 3):
        for points in inputs(dim, 20):
            tri = pbw.Delaunay(points)
            structure(tri)
            for corners in tri.simplices[::len(tri.simplices) // 20 + 1]:
                for q in points[:60]:
                    check(conflict(points[corners], [0] * (dim + 1), q, 0) <= 0)


@test
def regular_in_exact_arithmetic():
    for dim in (2, 3):
        rng = np.random.default_rng(dim)
        points, weights = rng.random((25, dim)), rng.random(25) / 5
        tri = pbw.Delaunay(points, weights=weights)
        structure(tri)
        check(len(tri.hidden) > 0 and len(tri.hidden) + len(np.unique(tri.simplices)) == 25)
        check((tri.vertex_to_simplex[tri.hidden] == -1).all())
        for corners in tri.simplices:
            for q, w in zip(points, weights):
                check(conflict(points[corners], weights[corners], q, w) <= 0)
        distance = tri.plane_distance(points)
        for i, q in enumerate(points):
            for t, corners in enumerate(tri.simplices):
                exact = conflict(points[corners], weights[corners], q, 0)
                check(abs(distance[i, t]) < 1e-12 or (exact > 0) == (distance[i, t] > 0))
        equal(pbw.Delaunay(points, weights=np.full(25, 3.0)).simplices, pbw.Delaunay(points).simplices)


@test
def find_simplex_in_exact_arithmetic():
    for dim in (2, 3):
        for points in inputs(dim, 20):
            tri = pbw.Delaunay(points)
            rng = np.random.default_rng(7)
            some = points[tri.simplices[rng.integers(0, tri.nsimplex, 20)]]
            queries = np.concatenate([points, some[:, :2].mean(axis=1), some[:, :3].mean(axis=1), some.mean(axis=1),
                                      points[:10] * 1.5 - 0.25, points + 0.5])[:300]
            found = tri.find_simplex(queries)
            equal(found, tri.find_simplex(queries, bruteforce=True))
            equal(found[::-1], [int(tri.find_simplex(q)) for q in queries[::-1]])
            for q, t in list(zip(queries, found.tolist()))[::7]:
                has = [s for s, c in enumerate(tri.simplices[:t + 1 if t >= 0 else None])
                       if all(orient(np.where(np.arange(dim + 1)[:, None] == k, q, points[c])) >= 0
                              for k in range(dim + 1))]
                check(has == ([t] if t >= 0 else []), has, t)


@test
def find_simplex_shapes_and_strange_queries():
    tri = pbw.Delaunay(np.random.default_rng(1).random((500, 2)))
    q = np.random.default_rng(2).random((4, 50, 2))
    equal(tri.find_simplex(q).shape, (4, 50))
    equal(tri.find_simplex(q).ravel(), tri.find_simplex(q.reshape(-1, 2)))
    equal(tri.find_simplex(q), pbw.tsearch(tri, q))
    check(tri.find_simplex(q[0, 0]).shape == () and tri.find_simplex(q[:0]).shape == (0, 50))
    equal(tri.find_simplex(np.full((200, 2), np.nan)), np.full(200, -1))
    equal(tri.find_simplex([[np.inf, 0], [0, -np.inf], [1e308, -1e308], [0.5, 0.5]])[:3], [-1, -1, -1])
    mixed = np.where(np.arange(400)[:, None] % 3 == 0, np.nan, q.reshape(-1, 2)[np.arange(400) % 200])
    equal(tri.find_simplex(mixed)[1::3], tri.find_simplex(mixed[1::3]))
    raises(ValueError, tri.find_simplex, [1.0, 2.0, 3.0])
    raises(ValueError, tri.find_simplex, 1.0)
    square = pbw.Delaunay([[0, 0], [1, 0], [0, 1], [1, 1]])
    outside = [[0.5, -1e-9], [1 + 1e-9, 0.5], [0.5, -1e-3]]
    for bruteforce in (False, True):
        equal(square.find_simplex(outside, bruteforce), [-1, -1, -1])
        near = square.find_simplex(outside, bruteforce, tol=1e-6)
        check((near[:2] >= 0).all() and near[2] == -1)


@test
def nearest_by_trying_all():
    for dim in (2, 3):
        for points in list(inputs(dim))[:4]:
            tri = pbw.Delaunay(points)
            rng = np.random.default_rng(7)
            queries = np.concatenate([points[:20], rng.integers(0, 7, (40, dim)) / 2, rng.random((20, dim)) * 9 - 4])
            distances, found = tri.nearest(queries, 7)
            own = sorted(set(range(len(points))) - set(tri.coplanar[:, 0].tolist()))
            exact = [[Fraction(x) for x in p] for p in points.tolist()]
            for i, q in enumerate(queries.tolist()):
                square = [sum((Fraction(x) - y) ** 2 for x, y in zip(q, exact[p])) for p in own]
                order = sorted(zip(square, own))[:7]
                equal(found[i], [p for _, p in order])
                check(np.allclose(distances[i] ** 2, [float(s) for s, _ in order], rtol=1e-13, atol=0))
            d, p = tri.nearest(queries)
            equal(p, found[:, 0])
            equal(d, distances[:, 0])
    for dim in (2, 3):                 # many calls with few queries share stars, which a pickle and a change leave out
        points = np.random.default_rng(8).random((500, dim))
        tri = pbw.Delaunay(points, incremental=True)
        distances, found = tri.nearest(points[:70] + 0.01, 5)
        for i in range(30):
            d, p = tri.nearest(points[i] + 0.01, 5)
            equal(p, found[i])
            equal(d, distances[i])
            check((tri._mesh._stars is not None) == (i >= 20))
        equal(pickle.loads(pickle.dumps(tri)).nearest(points[:70] + 0.01, 5)[1], found)
        tri.add_points([[0.5] * dim])
        equal(tri.nearest([0.5] * dim)[1], 500)
    square = pbw.Delaunay([[0, 0], [1, 0], [0, 1], [1, 1]])
    d, p = square.nearest([[[0, 0], [1, 1]]], 6)
    check(d.shape == p.shape == (1, 2, 6))
    equal(p[0], [[0, 1, 2, 3, 4, 4], [3, 1, 2, 0, 4, 4]])
    equal(np.isinf(d[0, 0]), [False] * 4 + [True] * 2)
    check(square.nearest([0.1, 0])[1].shape == () and square.nearest(np.zeros((0, 2)), 3)[0].shape == (0, 3))
    heavy = pbw.Delaunay([[0, 0], [1, 0], [0, 1], [1, 1]], weights=[0, 0, 0, 0.75])
    d, p = heavy.nearest([0.25, 0.5], 2)
    equal(p, [3, 0])
    equal(d, [0.0625, 0.3125])         # squares less weights
    raises_text(ValueError, r"xi\[1, 0\] is nan", square.nearest, [[0, 0], [np.nan, 0]])
    raises_text(ValueError, "k must be at least 1, not 0", square.nearest, [0, 0], 0)
    raises_text(ValueError, "wrong dimensionality", square.nearest, [0, 0, 0])


@test
def linear_functions_are_interpolated():
    for dim in (2, 3):
        slope = np.arange(1, dim + 1)
        for points in list(inputs(dim, 300))[:4]:
            tri = pbw.Delaunay(points)
            inside = tri.points[tri.simplices].mean(axis=1)
            inside = np.concatenate([inside, points, points[tri.simplices[:, :2]].mean(axis=1)])
            rounded_outside = tri.find_simplex(inside) < 0
            beside = inside[rounded_outside]
            check(np.isnan(pbw.interpolate(points, points @ slope, beside, tol=0)).all())
            check(np.allclose(pbw.interpolate(points, points @ slope, beside), beside @ slope, rtol=0, atol=1e-11))
            inside = inside[~rounded_outside]
            check(len(inside) > len(points))
            for method in ("linear", "sibson", "laplace"):
                found = pbw.interpolate(points, points @ slope + 3, inside, method=method)
                check(np.abs(found - inside @ slope - 3).max() < 1e-12, method)
                indptr, near, weights = tri.coordinates(inside, method)
                check((weights >= 0).all() and np.allclose(np.add.reduceat(weights, indptr[:-1]), 1, rtol=1e-13))
    rng = np.random.default_rng(1)
    points, xi = rng.random((200, 2)), rng.random((5, 40, 2)) * 2 - 0.5
    values = rng.random((200, 2, 3)) + 1j * rng.random((200, 2, 3))
    tri = pbw.Delaunay(points)
    outside = tri.find_simplex(xi) < 0
    check(outside.any() and not outside.all())
    for method in ("linear", "sibson", "laplace"):
        found = pbw.interpolate(tri, values, xi, method)
        check(found.shape == (5, 40, 2, 3) and found.dtype == complex)
        equal(np.isnan(found).all(axis=(2, 3)), outside)
        check(np.allclose(found[~outside][:, 1, 2].imag,
                          pbw.interpolate(points, values[:, 1, 2].imag, xi, method)[~outside]))
        check(np.allclose(pbw.interpolate(points, values, points, method), values))
    different = pbw.interpolate(tri, values, xi, "sibson") - pbw.interpolate(tri, values, xi)
    check(np.abs(different[~outside]).max() > 1e-3)
    equal(pbw.interpolate(np.vstack([points, points[:1]]), np.arange(201), points[0]), 0)
    raises_text(ValueError, "method must be one of linear, sibson, laplace, not 'cubic'", pbw.interpolate, points,
                values, xi, "cubic")
    raises_text(ValueError, r"values must have the shape \(200, ...\), .* not \(3,\)", pbw.interpolate, points,
                [1, 2, 3], xi)
    raises_text(ValueError, "values must be numbers", pbw.interpolate, points, ["a"] * 200, xi)
    raises_text(ValueError, r"xi\[0\] is inf", tri.coordinates, [np.inf, 0])
    found = pbw.interpolate(tri, values, [[np.nan, 0.5], [0.5, 0.5], [np.inf, 0], [9, 9]], outside="nearest")
    equal(np.isnan(found).all(axis=(1, 2)), [True, False, True, False])
    equal(found[3], values[tri.nearest([9, 9])[1]])
    raises_text(ValueError, "outside must be nan or nearest, not 0", pbw.interpolate, points, values, xi, outside=0)
    raises_text(ValueError, "tol must be from 0", pbw.interpolate, points, values, xi, tol=-1)


@test
def borders_are_inside():
    rng = np.random.default_rng(3)
    for dim in (2, 3):
        for origin in (0, 5e6):                      # as of coordinates of a map
            points = rng.random((80, dim)) + origin
            hull = pbw.Delaunay(points).convex_hull
            shares = rng.dirichlet(np.ones(dim), 1000)
            on = np.einsum("ij,ijk->ik", shares, points[hull[rng.integers(0, len(hull), 1000)]])
            for method in ("linear", "sibson", "laplace"):
                found = pbw.interpolate(points, points[:, 0], on, method)
                check(np.abs(found - on[:, 0]).max() < 1e-12 * max(1, origin), dim, origin, method)
            middle = points.mean(axis=0)
            check(np.isnan(pbw.interpolate(points, points[:, 0], middle + (on - middle) * (1 + 1e-5))).mean() > 0.9)
    # Borders that are straight up to rounding: ends of a border are corners of triangles as thin as that.
    side = np.linspace(0, 1, 13)
    for angle, scale, origin in ((0.3, 1, 0), (1.1, 1e-9, 0), (0.7, 1e9, 0), (0.2, 100, 4e6)):
        turn = scale * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        lattice = np.array([[x, y] for x in side for y in side]) @ turn.T + origin
        values = np.arange(169) % 5 * 1.0
        for first, step in ((0, 1), (0, 13), (156, 1), (12, 13)):
            row = first + step * np.arange(13)
            for share in (0.5, 0.25):
                places = (1 - share) * lattice[row[:-1]] + share * lattice[row[1:]]
                wanted = (1 - share) * values[row[:-1]] + share * values[row[1:]]
                check(np.abs(pbw.interpolate(lattice, values, places) - wanted).max() < 1e-5, angle, scale, first)
    cube = np.array([[x, y, z] for x in side[::3] for y in side[::3] for z in side[::3]])
    turn = np.linalg.qr(rng.random((3, 3)))[0]
    values = np.arange(125) % 4 * 1.0
    face = np.flatnonzero(cube[:, 2] == 0).reshape(5, 5)
    middles = (cube[face[:-1]] + cube[face[1:]]).reshape(-1, 3) / 2 @ turn.T
    check(np.abs(pbw.interpolate(cube @ turn.T, values, middles)
                 - (values[face[:-1]] + values[face[1:]]).reshape(-1) / 2).max() < 1e-9)


def unit_rows(rows):
    """Of normal . x <= bound with one normal, the tightest; the first number of each normal is 1 or -1."""
    tight = {}
    for normal, bound in rows:
        lead = next((abs(x) for x in normal if x), None)
        if lead is None and bound < 0:
            return None
        if lead is not None:
            normal = tuple(x / lead for x in normal)
            tight[normal] = min(bound / lead, tight.get(normal, bound / lead))
    return tight


def facet_size(tight, normal):
    """The volume of a polytope's facet, over the length of its normal."""
    j = next(k for k, x in enumerate(normal) if x)
    rest = [([a - m[j] / normal[j] * b for k, (a, b) in enumerate(zip(m, normal)) if k != j],
             c - m[j] / normal[j] * tight[normal]) for m, c in tight.items() if m != normal]
    return volume(rest) / abs(normal[j])


def volume(rows):
    """Of a polytope, by facets; Lasserre 1983."""
    tight = unit_rows(rows)
    if tight is None:
        return Fraction(0)
    if len(rows[0][0]) == 1:
        return max(tight[(1,)] + tight[(-1,)], Fraction(0))
    return sum(b * facet_size(tight, n) for n, b in tight.items() if b) / len(rows[0][0])


def exact_weights(points, weights, q, method):
    """Sibson's or Laplace's, from the definition, as fractions; KeyError if the cell of q is unbounded."""
    x = [[Fraction(a) - Fraction(b) for a, b in zip(p, q)] for p in points]
    power = [sum(a * a for a in p) - Fraction(w) for p, w in zip(x, weights)]
    scale = [next(2 * abs(a) for a in p if a) for p in x]
    wall = [(tuple(2 * a / s for a in p), h / s) for p, h, s in zip(x, power, scale)]
    tight = unit_rows(wall)
    gains = {}
    for i, (normal, bound) in enumerate(wall):
        if method == "laplace":
            gains[i] = facet_size(tight, normal) / scale[i] if tight[normal] == bound else 0
        else:                                            # also of a site with its cell inside that of q
            gains[i] = volume(list(tight.items()) + [([2 * (a - b) for a, b in zip(x[k], x[i])], power[k] - power[i])
                                                     for k in range(len(x)) if k != i])
    return {i: float(gain / sum(gains.values())) for i, gain in gains.items()}


def nearly_degenerate(kind, dim, rng):
    """Points on a line but for rounding, amid far ones too; at powers of two; twins one ulp apart."""
    count = 12 if dim == 2 else 8
    points = rng.random((count, dim))
    if kind.startswith("line"):
        points = np.outer(rng.random(count), 0.3 * np.arange(1, dim + 1)) + 0.1 * np.arange(dim)
        points = np.nextafter(points, points + rng.integers(-1, 2, points.shape))
    elif kind == "powers":
        points = np.ldexp(rng.integers(-1, 2, points.shape), -rng.integers(0, 40, points.shape))
    elif kind == "twins":
        points[1::2] = np.nextafter(points[::2], points[::2] + rng.integers(-1, 2, points[::2].shape))
    if kind == "line, far":
        points[:2**dim] = (30 + points[:2**dim]) * list(itertools.product((-1, 1), repeat=dim))
    return np.unique(points + 0.0, axis=0)


@test
def weights_are_exact_where_points_are_nearly_degenerate():
    rng = np.random.default_rng(7)
    compared = 0
    for dim, kind in itertools.product((2, 3), ("line", "line, far", "powers", "twins")):
        for trial in range(4 if dim == 2 else 1):
            points = nearly_degenerate(kind, dim, rng)
            heights = rng.random(len(points)) * 1e-5 * (trial % 2)
            a, b, c = points[rng.choice(len(points), 3, replace=False)]
            q = 0.3 * a + 0.7 * (0.6 * b + 0.4 * c)
            tri = pbw.Delaunay(points, weights=heights if trial % 2 else None)
            for method in ("sibson", "laplace"):
                found = tri.coordinates(q[None], method)
                if len(found[1]) <= dim + 1:
                    continue                             # outside, on the hull, or a hidden point
                try:
                    true = exact_weights(points.tolist(), heights.tolist(), q.tolist(), method)
                except KeyError:
                    continue
                weights = np.zeros(len(points))
                weights[found[1]] = found[2]
                compared += 1
                for i in range(len(points)):
                    check(abs(weights[i] - true.get(i, 0)) < 1e-9, (kind, dim, method, i, weights[i], true.get(i, 0)))
                check(np.abs(weights @ points - q).max() < 1e-9)
    check(compared > 12)


def closed(cells, dim):
    """For each bounded cell areas times normals add up to zero, and its pyramids to its volume."""
    for i, volume in enumerate(cells.volumes.tolist()):
        if not 0 < volume < np.inf:
            continue
        total, pyramids = np.zeros(dim), 0.0
        for j in range(cells.first[i], cells.first[i + 1]):
            corner = cells.vertices[cells.loops[cells.loop_first[j]:cells.loop_first[j + 1]]]
            if dim == 2:
                normal = (corner[1] - corner[0])[::-1] * [1, -1]
            else:
                normal = np.cross(corner[1:-1] - corner[0], corner[2:] - corner[0]).sum(axis=0) / 2
            check(abs(np.sqrt(normal @ normal) - cells.areas[j]) < 1e-12)
            total += normal
            pyramids += normal @ corner[0] / dim
        check(np.abs(total).max() < 1e-12 and abs(pyramids - volume) < 1e-12, i, total, pyramids, volume)


@test
def cells_of_lattices_and_of_weights():
    for dim in (2, 3):
        lattice = np.array(list(itertools.product(range(4), repeat=dim)), float)
        box = [[-0.5] * dim, [3.5] * dim]
        for axes in ("", "x", "xyz"[:dim]):
            cells = pbw.power_cells(lattice, None, box, periodic=axes, merge=True)
            check(np.allclose(cells.volumes, 1, rtol=1e-13) and np.allclose(cells.centroids, lattice, atol=1e-13))
            closed(cells, dim)
        equal(np.diff(cells.first), [2 * dim] * len(lattice))
        check(np.allclose(cells.areas, 1) and set(cells.shifts.ravel().tolist()) == {-1, 0, 1})
        one = pbw.power_cells([[0.25] * dim], box=[[0] * dim, [1, 2, 3][:dim]], periodic="xyz"[:dim], merge=True)
        check(np.isclose(one.volumes[0], [2, 6][dim - 2]) and set(one.neighbors.tolist()) == {0})
        free = pbw.power_cells(lattice, merge=True)
        check(free.shifts is None and np.isinf(free.volumes).sum() == 4 ** dim - 2 ** dim)
        check(np.isclose(free.volumes[np.isfinite(free.volumes)], 1).all())
        rng = np.random.default_rng(2)
        points, weights = rng.random((40, dim)), rng.random(40) * 0.2
        unit = [[0] * dim, [1] * dim]
        cells = pbw.power_cells(points, weights, box=unit)
        closed(cells, dim)
        check(abs(cells.volumes.sum() - 1) < 1e-13 and (cells.volumes == 0).sum() > 1)
        grid = np.stack(np.meshgrid(*[(np.arange(40) + 0.5) / 40] * dim), axis=-1).reshape(-1, dim)
        distance = np.array([((grid - p) ** 2).sum(axis=1) - w for p, w in zip(points, weights)])
        share = np.bincount(distance.argmin(axis=0), minlength=40) / len(grid)
        check(np.abs(share - cells.volumes).max() < 5e-3, share, cells.volumes)
        equal(pbw.power_cells(points, weights, unit, threads=1).vertices, cells.vertices)
        skew = np.eye(dim) + np.tril(np.full((dim, dim), 3), -1)         # the same lattice as the unit box
        boxed = pbw.power_cells(points, weights, unit, periodic="xyz"[:dim])
        cells = pbw.power_cells(points, weights, lattice=skew)
        check(np.allclose(cells.volumes, boxed.volumes, atol=1e-13))
        check(np.abs(cells.sites - points - np.round(cells.sites - points)).max() < 1e-12)
        equal(np.diff(cells.first), np.diff(boxed.first))
        images = []                               # where neighbours are, from each site
        for one, vectors in ((boxed, np.eye(dim)), (cells, skew)):
            of = np.repeat(np.arange(40), np.diff(one.first))
            to = one.sites[one.neighbors] + one.shifts @ vectors - one.sites[of]
            images.append(np.array(sorted(zip(of, *np.round(to, 9).T + 0.0))))
        check(np.allclose(*images, atol=1e-8))
        raises_text(ValueError, "exclude each other", pbw.power_cells, points, box=unit, lattice=skew)
        raises_text(ValueError, "lattice must be", pbw.power_cells, points, lattice=skew[0])
        for axes, bad, text in (("xw", unit, "periodic must have letters of"),
                                ("x", None, "periodic='x' needs a box"),
                                ("", unit[::-1], "box must be a low corner and a high"),
                                ("", [0, 1], "%d finite numbers, not" % (2 * dim))):
            raises_text(ValueError, text, pbw.power_cells, points, weights, bad, periodic=axes)
    raises(pbw.Error, pbw.power_cells, np.zeros((5, 2)))


@test
def cells_of_flat_points():
    """One point, points on a line and in a plane, in a box; some twice, with weights that hide some."""
    for dim in (2, 3):
        box = [[0] * dim, [4, 6, 8][:dim]]
        line = np.outer(np.arange(1, 4), [1, 1, 2][:dim])
        for points in ([[1] * dim], [[1] * dim, [3] * dim], line, np.concatenate([line, line[:1]]),
                       np.column_stack([line[:, 0], np.full((3, dim - 1), 2)])):
            for weights in (None, np.arange(len(points)) * 3.0):
                for merge in (False, True):
                    cells = pbw.power_cells(points, weights, box, merge=merge)
                    closed(cells, dim)
                    check(abs(cells.volumes.sum() - np.prod(box[1])) < 1e-11, cells.volumes)
            check((pbw.lloyd(points, 3, box).mean(axis=0) > 0).all())
        check(np.allclose(pbw.power_cells([[1] * dim, [3] * dim], box=[[0] * dim, [4] * dim]).volumes, 4 ** dim / 2))
        check(np.allclose(pbw.lloyd([[1] * dim], 1, box), np.array(box[1]) / 2))
    flat = [[1, 1, 2], [4, 1, 2], [1, 5, 2], [4, 5, 2]]
    cells = pbw.power_cells(flat, box=[0, 0, 0, 5, 6, 4], merge=True)
    check(np.allclose(cells.volumes, 30))
    equal(np.diff(cells.first), [6] * 4)
    raises(pbw.Error, pbw.power_cells, flat)
    raises_text(ValueError, "box must be a low corner and a high", pbw.lloyd, flat)


@test
def cells_by_a_gpu():
    """The same as by the CPU; without CUDA or without a GPU an error that says so."""
    rng = np.random.default_rng(5)
    for dim in (2, 3):
        points, weights, box = rng.random((3000, dim)), rng.random(3000) * 1e-3, [[0.1] * dim, [1] * dim]
        try:
            cells = pbw.power_cells(points, weights, box, device="cuda")
        except pbw.Error as e:
            check(re.search("^device='cuda': (pbw was built without CUDA: PBW_CUDA=1 |no usable device)", str(e)), e)
        else:
            expected = pbw.power_cells(points, weights, box)
            for name in ("volumes", "centroids", "first", "neighbors", "areas"):
                equal(getattr(cells, name), getattr(expected, name))
            equal(pbw.lloyd(points, 3, box, device="cuda"), pbw.lloyd(points, 3, box))
            cells = pbw.power_cells(points, box=box, periodic="x", device="cuda")
            expected = pbw.power_cells(points, box=box, periodic="x")
            for name in ("volumes", "sites", "areas", "shifts") if dim == 3 else ("sites",):
                equal(getattr(cells, name), getattr(expected, name))
        raises_text(ValueError, "device must be 'cpu' or 'cuda', not 'gpu'", pbw.power_cells, points, device="gpu")
        for more in ({"merge": True}, {"lattice": np.eye(dim)}):
            raises_text(ValueError, "device='cuda' makes no cells with " + list(more)[0], pbw.power_cells, points,
                        box=box, device="cuda", **more)


@test
def lloyd_lowers_the_energy():
    for dim in (2, 3):
        for axes in ("", "x"):
            start = np.random.default_rng(3).random((200, dim))
            box, energy = [[0] * dim, [1] * dim], []
            equal(pbw.lloyd(start, 0), start)
            sample = np.random.default_rng(4).random((20000, dim))
            for steps in (0, 1, 2, 4, 16):
                points = pbw.lloyd(start, steps, box, periodic=axes)
                shifts = (-1, 0, 1) if axes else (0,)
                copies = np.concatenate([points + np.eye(dim)[0] * s for s in shifts])
                energy.append((pbw.Delaunay(copies).nearest(sample)[0] ** 2).mean())
            check(all(a > b for a, b in zip(energy, energy[1:])) and energy[-1] < 0.8 * energy[0], energy)
            equal(pbw.lloyd(pbw.lloyd(start, 2, box, periodic=axes), 2, box, periodic=axes),
                  pbw.lloyd(start, 4, box, periodic=axes))
    raises_text(ValueError, "steps must not be negative", pbw.lloyd, start, -1)


@test
def lloyd_in_lattices():
    """As in the box that is the same lattice; cells of skew ones against cells among images; the energy falls."""
    for dim in (2, 3):
        start = np.random.default_rng(8).random((30, dim))
        size = np.array([1.0, 1.5, 0.75])[:dim]
        boxed = pbw.lloyd(start * size, 3, [[0] * dim, size], periodic="xyz"[:dim])
        for turn in (np.eye(dim), np.eye(dim) + np.tril(np.full((dim, dim), 2.0), -1)):
            points = pbw.lloyd(start * size, 3, lattice=turn @ np.diag(size))
            moved = (points - boxed) / size
            check(np.abs(moved - np.round(moved)).max() < 1e-11, moved)
        lattice = np.array([[1, 0.1, 0.2], [0.3, 0.9, -0.1], [-0.2, 0.4, 1.1]])[:dim, :dim]
        points = start @ lattice
        shifts = np.array(list(itertools.product((0, 1, -1, 2, -2), repeat=dim))) @ lattice
        images = (shifts[:, None] + points).reshape(-1, dim)
        wanted = pbw.power_cells(images, box=[[-9] * dim, [9] * dim]).centroids[:30]
        moved = (pbw.lloyd(points, 1, lattice=lattice) - wanted) @ np.linalg.inv(lattice)
        check(np.abs(moved - np.round(moved)).max() < 1e-11, moved)
        equal(pbw.lloyd(pbw.lloyd(points, 1, lattice=lattice), 2, lattice=lattice),
              pbw.lloyd(points, 3, lattice=lattice))
        sample, energy = np.random.default_rng(4).random((5000, dim)) @ lattice, []
        for steps in (0, 1, 4, 16):
            points = pbw.lloyd(start @ lattice, steps, lattice=lattice)
            images = (shifts[:, None] + points).reshape(-1, dim)
            energy.append((pbw.Delaunay(images).nearest(sample)[0] ** 2).mean())
        check(all(a > b for a, b in zip(energy, energy[1:])) and energy[-1] < 0.9 * energy[0], energy)
        raises_text(ValueError, "exclude each other", pbw.lloyd, start, 1, [[0] * dim, size], lattice=lattice)
        raises_text(ValueError, "lattice must be", pbw.lloyd, start, 1, lattice=lattice[0])
        raises_text(ValueError, "needs a box", pbw.lloyd, start, 1, lattice=lattice, periodic="x")


def squared_radius(corners, weights):
    """Of the sphere orthogonal to the balls of a simplex's corners, exactly."""
    p, w = [[Fraction(x) for x in corner] for corner in corners.tolist()], [Fraction(x) for x in weights.tolist()]
    edges = [[x - y for x, y in zip(q, p[0])] for q in p[1:]]
    sides = [(sum(x * x for x in e) + w[0] - v) / 2 for e, v in zip(edges, w[1:])]
    det = determinant(edges)
    centre = [determinant([e[:k] + [h] + e[k + 1:] for e, h in zip(edges, sides)]) / det for k in range(len(edges))]
    return sum(x * x for x in centre) - w[0]


@test
def alpha_shapes():
    """Against exact radii and lengths, and the program."""
    program = os.path.abspath(os.path.join(os.path.dirname(os.environ.get("PBW_LIBRARY", "")), "pbw"))
    for dim in (2, 3):
        rng = np.random.default_rng(dim)
        points = rng.random((200, dim))
        for weights in (None, rng.random(200) * 0.004):
            tri = pbw.Delaunay(points, weights=weights)
            own = np.zeros(200) if weights is None else weights
            radius = np.array([float(max(0, squared_radius(points[s], own[s]))) for s in tri.simplices]) ** 0.5
            length = np.array([max(np.linalg.norm(a - b) for a, b in itertools.combinations(points[s], 2))
                               for s in tri.simplices])
            for alpha, longest in ((0.08, np.inf), (np.inf, 0.2), (0.2, 0.3), (np.inf, np.inf), (1e-9, 1e-9)):
                kept = tri.alpha_shape(alpha, longest)
                equal(kept, (radius <= alpha) & (length <= longest))
                check(kept.dtype == bool and kept.shape == (tri.nsimplex,))
            if os.path.exists(program):
                with tempfile.TemporaryDirectory() as folder:
                    np.savetxt(os.path.join(folder, "p.csv"), np.column_stack([points, own]), "%.17g", ",")
                    words = [program, "p.csv", "-o", "p.ele", "--alpha", "0.2", "--longest", "0.3", "--dim", str(dim)]
                    subprocess.run(words + ([] if weights is None else ["--weights", str(dim + 1)]), cwd=folder,
                                   check=True, capture_output=True)
                    rows = np.loadtxt(os.path.join(folder, "p.ele"), skiprows=1, dtype=int)
                wanted = tri.simplices[tri.alpha_shape(alpha=0.2, longest=0.3)]
                check(sets(rows[:, 1:dim + 2]) == sets(wanted))
        square = 3 * np.array(list(itertools.product((0, 1), repeat=dim)), float)
        for scale in (1, 1e-150, 1e150):
            tri = pbw.Delaunay(square * scale)
            check(tri.alpha_shape(1.5 * dim ** 0.5 * (1 + 1e-12) * scale).all())
            check(not tri.alpha_shape(1.5 * dim ** 0.5 * (1 - 1e-12) * scale).any())
            check(tri.alpha_shape(longest=3 * dim ** 0.5 * (1 + 1e-12) * scale).all())
        raises_text(ValueError, "alpha must be above 0", tri.alpha_shape, 0)
        raises_text(ValueError, "longest must be above 0", tri.alpha_shape, 1, float("nan"))


@test
def voronoi_in_scipys_words():
    """The example of SciPy's documentation, whatever the order."""
    points = np.array(list(itertools.product(range(3), repeat=2)))
    vor = pbw.Voronoi(points)
    named = {tuple(p): i for i, p in enumerate([[0.5, 0.5], [0.5, 1.5], [1.5, 0.5], [1.5, 1.5]])}
    name = {-1: -1, **{i: named[tuple(p)] for i, p in enumerate(vor.vertices.tolist())}}
    check(len(vor.vertices) == 4)
    pairs = [(0, 3), (0, 1), (2, 5), (2, 1), (1, 4), (7, 8), (7, 6), (7, 4), (8, 5), (6, 3), (4, 5), (4, 3)]
    ends = [[-1, 0], [-1, 0], [-1, 1], [-1, 1], [0, 1], [-1, 3], [-1, 2], [2, 3], [-1, 3], [-1, 2], [1, 3], [0, 2]]
    ridges = {tuple(pair): sorted(map(name.get, ridge)) for pair, ridge in vor.ridge_dict.items()}
    check(ridges == {tuple(sorted(pair)): end for pair, end in zip(pairs, ends)}, ridges)
    regions = sorted(sorted(map(name.get, region)) for region in vor.regions)
    check(regions == sorted(map(sorted, [[], [-1, 0], [-1, 1], [1, -1, 0], [3, -1, 2], [-1, 3], [-1, 2], [0, 1, 3, 2],
                                         [2, -1, 0], [3, -1, 1]])), regions)
    middle = [vor.vertices[v] for v in vor.regions[vor.point_region[4]]]
    check(all(np.abs(a - b).sum() == 1 for a, b in zip(middle, middle[1:] + middle[:1])))      # in order
    check(repr(vor) == "<pbw.Voronoi: 9 points in 2D, 4 vertices, 12 ridges>")
    again = pbw.Voronoi(np.concatenate([points, points[:2]]))
    equal(again.point_region, list(range(1, 10)) + [1, 2])
    vor = pbw.Voronoi(points[:5], incremental=True)
    vor.add_points(points[5:])
    check(sets(vor.ridge_points) == sets(pbw.Voronoi(points).ridge_points) and vor.npoints == 9)
    vor.add_points(points + 0.25, restart=True)
    vor.add_points(points - 0.25)
    all_points = np.concatenate([points, points + 0.25, points - 0.25])
    check(sets(vor.ridge_points) == sets(pbw.Voronoi(all_points).ridge_points))
    equal(vor.points, all_points)
    vor.close()
    raises(RuntimeError, vor.add_points, points)
    for copied in (pickle.loads(pickle.dumps(vor)), copy.deepcopy(vor)):
        equal(copied.vertices, vor.vertices)
        check(copied.regions == vor.regions and copied.ridge_dict == vor.ridge_dict)
        equal(copied.point_region, vor.point_region)
    raises(pbw.QhullError, pbw.Voronoi, points * [1, 0])
    raises_text(ValueError, "furthest_site is not", pbw.Voronoi, points, furthest_site=True)


@test
def barycentric_coordinates():
    for dim in (2, 3):
        tri = pbw.Delaunay(np.random.default_rng(3).random((300, dim)))
        q = np.random.default_rng(4).random((200, dim)) * 0.5 + 0.25
        t = tri.transform[tri.find_simplex(q)]
        b = np.einsum("ijk,ik->ij", t[:, :dim], q - t[:, dim])
        b = np.column_stack([b, 1 - b.sum(axis=1)])
        check((b > -1e-12).all())
        thin = pbw.Delaunay(np.vstack([np.zeros(dim), np.eye(dim)[:-1], np.full(dim, 1e-14)]))
        check(np.isnan(thin.transform[:, :dim]).all() and not np.isnan(thin.equations).any())
        check(np.allclose(np.einsum("ij,ijk->ik", b, tri.points[tri.simplices[tri.find_simplex(q)]]), q))


@test
def hull_and_neighbors():
    for dim in (2, 3):
        for points in inputs(dim):
            tri = pbw.Delaunay(points)
            for facet in tri.convex_hull[:40]:
                check(all(orient([*points[facet], q]) * (1 if dim == 2 else -1) >= 0 for q in points[:60]))
            indptr, indices = tri.vertex_neighbor_vertices
            for p in range(len(points)):
                star = tri.simplices[(tri.simplices == p).any(axis=1)]
                equal(indices[indptr[p]:indptr[p + 1]], [v for v in np.unique(star) if v != p])


@test
def lattice_is_tiled():
    for dim, simplex in ((2, 2), (3, 6)):
        points = np.array(list(itertools.product(range(9), repeat=dim)), float)
        corner = points[pbw.Delaunay(points).simplices]
        volumes = np.linalg.det(corner[:, 1:] - corner[:, :1]) / simplex
        check((volumes > 0).all() and np.isclose(volumes.sum(), 8 ** dim))


@test
def documented_examples():
    """Those of SciPy's reference and tutorial, told so that the order of simplices does not matter."""
    points = np.array([[0, 0], [0, 1.1], [1, 0], [1, 1]])
    tri = pbw.Delaunay(points)
    check(sets(tri.simplices) == {(0, 2, 3), (0, 1, 3)} and tri.simplices.dtype == np.int32)
    one = [t for t in (0, 1) if 1 in tri.simplices[t]][0]
    equal(sorted(tri.neighbors[one]), [-1, -1, 1 - one])
    equal(points[tri.simplices[one][list(tri.neighbors[one]).index(1 - one)]], [0, 1.1])
    p = np.array([(0.1, 0.2), (1.5, 0.5), (0.5, 1.05)])
    equal(tri.find_simplex(p), [one, -1, one])
    b = tri.transform[one, :2].dot(np.transpose(p - tri.transform[one, 2]))
    b = np.c_[np.transpose(b), 1 - b.sum(axis=0)][:, [list(tri.simplices[one]).index(v) for v in (3, 1, 0)]]
    check(np.allclose(b, [[0.1, 0.09090909, 0.80909091], [1.5, -0.90909091, 0.40909091], [0.5, 0.5, 0]]), b)

    tri = pbw.Delaunay(np.array([[0, 0], [0, 1], [1, 0], [1, 1], [1, 1]]))
    equal(np.unique(tri.simplices.ravel()), [0, 1, 2, 3])
    equal(tri.coplanar[:, [0, 2]], [[4, 3]])
    check(3 in tri.simplices[tri.coplanar[0, 1]] and tri.vertex_to_simplex[4] == tri.vertex_to_simplex[3])


@test
def bad_arguments():
    good = np.random.default_rng(5).random((10, 3))
    bad = good.copy()
    bad[3, 1] = np.nan
    for points, text in ((bad, r"points\[3, 1\] is nan: it must be finite"),
                         (np.where(np.isnan(bad), np.inf, bad), r"points\[3, 1\] is inf"),
                         (good[0], r"points must have the shape \(npoints, 2\) or \(npoints, 3\), not \(3,\)"),
                         (good[:, :1], r"not \(10, 1\)"), (np.zeros((9, 4)), r"not \(9, 4\)"),
                         (good[None], r"not \(1, 10, 3\)"),
                         (np.ma.masked_array(good, np.isnan(bad)), "points cannot be a masked array")):
        raises_text(ValueError, text, pbw.Delaunay, points)
    nan = np.where(np.arange(10) == 7, np.nan, 1.0)
    raises_text(ValueError, r"weights must have the shape \(10,\), .* not \(1,\)", pbw.Delaunay, good, weights=[1.0])
    raises_text(ValueError, r"weights\[7\] is nan", pbw.Delaunay, good, weights=nan)
    for threads in (-1, 257):
        raises_text(ValueError, r"threads must be 0 .* to 256, not %d" % threads, pbw.Delaunay, good, threads=threads)
    raises(TypeError, pbw.Delaunay, good, threads=1.5)
    raises_text(ValueError, "furthest_site is not", pbw.Delaunay, good, furthest_site=True)
    raises_text(ValueError, "option QG4 is not", pbw.Delaunay, good, qhull_options="Qbb QG4")
    equal(pbw.Delaunay(good, qhull_options="Qbb Qc").simplices, pbw.Delaunay(good).simplices)
    for flat, text in ((np.zeros((10, 3)), "1 of 10 points are distinct, and 3D needs at least 4"),
                       (good[:3], "3 of 3 points are distinct"), (np.zeros((0, 2)), "0 of 0 points are"),
                       (good * [1, 1, 0], "all 10 points lie exactly in one plane"),
                       (good[:, :2] * [1, 0], "all 10 points lie exactly on one line")):
        raises_text(pbw.QhullError, text, pbw.Delaunay, flat)
    check(issubclass(pbw.QhullError, RuntimeError))
    tri = pbw.Delaunay(good, incremental=True)
    raises_text(ValueError, r"the shape \(n, 3\), not \(10, 2\)", tri.add_points, good[:, :2])
    equal(tri.npoints, 10)


@test
def words_about_itself():
    points = np.random.default_rng(5).random((10, 2))
    tri = pbw.Delaunay(points)
    equal(repr(tri), "<pbw.Delaunay: 10 points in 2D, %d simplices>" % tri.nsimplex)
    equal(repr(pbw.Delaunay(np.concatenate([points, points[:4]]))),
          "<pbw.Delaunay: 14 points in 2D, 4 duplicate, %d simplices>" % tri.nsimplex)
    check(repr(pbw.Delaunay(points, weights=np.arange(10.0))).startswith("<pbw.Delaunay: 10 weighted points in 2D, "))
    with open("pbw.h") as header:
        numbers = re.findall(r"^#define PBW_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)$", header.read(), re.M)
    equal(pbw.__version__, ".".join(numbers))
    check(all(hasattr(pbw, name) for name in pbw.__all__) and len(numbers) == 3)
    equal(tri.good, np.ones(tri.nsimplex, np.int32))


@test
def scipy_is_not_needed():
    code = """
import sys
if sys.argv[1] == "none":
    sys.modules["scipy"] = sys.modules["scipy.spatial"] = None
import numpy, pickle, pbw
tri = pickle.loads(pickle.dumps(pbw.Delaunay([[0, 0], [1, 0], [0, 1], [3, 3]])))
assert tri.find_simplex([0.2, 0.2]) >= 0 and tri.__class__ is type(tri) is pbw.Delaunay
try:
    pbw.Delaunay([[0, 0], [1, 1], [2, 2]])
except pbw.Error as e:
    assert type(e) is pbw.Error
assert sys.argv[1] == "none" or not any(name.startswith("scipy") for name in sys.modules)
"""
    for what in ("none", "there"):
        done = subprocess.run([sys.executable, "-c", code, what], stderr=subprocess.PIPE)
        check(done.returncode == 0, done.stderr.decode())


@test
def kinds_of_arrays():
    points = np.random.default_rng(6).integers(0, 100, (200, 2))
    want = pbw.Delaunay(points.astype(float)).simplices
    for same in (points, points.tolist(), points.astype(np.float32), np.asfortranarray(points.astype(float)),
                 np.repeat(points, 2, axis=0)[::2], np.hstack([points, points])[:, :2]):
        equal(pbw.Delaunay(same).simplices, want)
    tri = pbw.Delaunay(points)
    found = tri.find_simplex(points[:50] + 0.25)
    for name in ("points", "simplices", "neighbors", "vertex_to_simplex", "equations", "transform", "convex_hull",
                 "coplanar", "good", "min_bound", "max_bound"):
        array = getattr(tri, name)
        check(array is getattr(tri, name) and array.flags.writeable and array.flags.c_contiguous, name)
        array[...] = 7
    equal(tri.find_simplex(points[:50] + 0.25, bruteforce=True), found)
    tri.simplices = tri.simplices[:2]  # as people do who look at a part of it
    equal(len(tri.simplices), 2)
    tri = pbw.Delaunay(points)
    equal(tri.find_simplex(points[:50] + 0.25), found)
    points[:] = 0                      # the triangulation has its own
    equal(pickle.loads(pickle.dumps(tri)).find_simplex([[50, 50]]), tri.find_simplex([[50, 50]]))
    for name in ("float32", "float64"):
        points = np.random.default_rng(7).random((500, 3)).astype(name)
        equal(pbw.Delaunay(points).simplices, pbw.Delaunay(points.astype(float)).simplices)


@test
def points_added():
    points = np.random.default_rng(8).random((300, 3))
    tri = pbw.Delaunay(points[:100], incremental=True)
    before = len(tri.convex_hull)
    tri.add_points(points[100:])
    equal(tri.simplices, pbw.Delaunay(points).simplices)
    equal(tri.points, points)
    check(before != len(tri.convex_hull))
    tri.add_points(points[:50] / 2, restart=True)
    equal(tri.simplices, pbw.Delaunay(np.concatenate([points, points[:50] / 2])).simplices)
    points = np.concatenate([points, points[:50] / 2])
    for bad in ([[0.5, np.nan, 0]], np.ma.array(points, mask=points > 2)):
        raises(ValueError, tri.add_points, bad)
    tri.add_points(np.empty((0, 3)))
    equal(tri.simplices, pbw.Delaunay(points).simplices)       # what failed is in no queue
    tri = pickle.loads(pickle.dumps(tri))
    tri.add_points(points[:20] * 2)
    points = np.concatenate([points, points[:20] * 2])
    equal(tri.neighbors, pbw.Delaunay(points).neighbors)
    tri.close()
    raises(RuntimeError, tri.add_points, points)
    raises(RuntimeError, tri.add_points, points, restart=True)
    tri.close()
    check(tri.find_simplex(points[:9].mean(axis=0)) >= 0)
    raises(RuntimeError, pbw.Delaunay(points).add_points, points)
    weights = np.random.default_rng(9).random(len(points)) / 9
    tri = pbw.Delaunay(points[:99], incremental=True, weights=weights[:99])
    raises_text(ValueError, "points are added with weights where", tri.add_points, points[99:])
    tri.add_points(points[99:], weights=weights[99:])
    equal(tri.simplices, pbw.Delaunay(points, weights=weights).simplices)
    stop = threading.Event()

    def progress(stage, done):
        if stop.is_set():
            raise KeyError(stage)
    tri = pbw.Delaunay(points, incremental=True, progress=progress)
    stop.set()
    raises(KeyError, tri.add_points, points / 3)
    stop.clear()
    tri.add_points(points / 5)
    equal(tri.simplices, pbw.Delaunay(np.concatenate([points, points / 5])).simplices)


def same_as_anew(live):
    """Equal to the triangulation of the points there are, in the order of their numbers."""
    numbers, weights = live.numbers, live.weights
    rebuilt = pbw.Delaunay(live.points[numbers], weights=None if weights is None else weights[numbers])
    equal(live.simplices, numbers[rebuilt.simplices])
    equal(live.neighbors, rebuilt.neighbors)
    equal(live.vertex_to_simplex[numbers], rebuilt.vertex_to_simplex)
    equal(live.hidden, numbers[rebuilt.hidden])
    for name in ("convex_hull", "min_bound", "max_bound"):
        ours, theirs = getattr(live, name), getattr(rebuilt, name)
        equal(ours, numbers[theirs] if name == "convex_hull" else theirs)
    middle = live.points[numbers].mean(axis=0)
    equal(live.find_simplex(middle), rebuilt.find_simplex(middle))
    equal(live.nearest(middle, 5)[1], numbers[rebuilt.nearest(middle, 5)[1]])


@test
def points_that_live():
    for seed, dim in enumerate((2, 3, 2, 3)):
        random, weighted = np.random.default_rng(seed), seed > 1
        points = random.integers(0, 12, (150, dim)).astype(float)            # with duplicates and ties
        live = pbw.Live(points, random.random(150) if weighted else None)
        same_as_anew(live)
        for step in range(12):
            before, numbers = sets(live.simplices), live.numbers
            stay = random.permutation(numbers)
            live.remove(stay[:20 + step])
            more = random.integers(0, 12, (25, dim)) / [1.0, 2.0][step % 2]
            ids = live.insert(more, random.random(25) if weighted else None)
            live.move(ids[:2], more[2:4])
            live.move(stay[60:90], live.points[stay[60:90]] + random.random((30, dim)) / 9)
            equal(live.numbers, numbers)                                  # until the commit
            changes = live.commit()
            same_as_anew(live)
            equal(live.points[ids[:2]], more[2:4])
            check(changes.way in ("batch", "rebuild"))
            check((before - sets(changes.deleted)) | sets(changes.made) == sets(live.simplices))
            check(set(np.concatenate([changes.deleted, changes.made]).ravel()) >= set(changes.points.tolist()))
        live.move(None, live.points)
        equal(live.commit().way, "nothing")
        check(live.commit(changes=False) is None)


@test
def points_that_live_and_what_is_refused():
    points = np.random.default_rng(1).random((30, 2))
    live = pbw.Live(points)
    for ids in ([30], [-1], [1, 1], [0.5], ["a"], [[1]], [2 ** 40]):
        raises_text(ValueError, "ids must be numbers of points", live.remove, ids)
    raises_text(ValueError, r"shape \(1, 2\), not \(2, 2\)", live.move, [1], points[:2])
    raises_text(ValueError, r"shape \(n, 2\), not \(1, 3\)", live.insert, np.zeros((1, 3)))
    raises_text(ValueError, r"points\[0, 1\] is nan", live.insert, [[0, np.nan]])
    raises_text(ValueError, "with weights where", live.insert, points, weights=np.zeros(30))
    raises(TypeError, pickle.dumps, live)
    live.remove(np.arange(28))
    equal(live.nsimplex, len(pbw.Delaunay(points).simplices))
    live.commit()
    equal(live.simplices.shape, (0, 3))
    equal(live.numbers, [28, 29])
    check(live.hidden.shape == (0,) and live.coplanar.shape == (0, 3) and live.find_simplex([0.5, 0.5]) == -1)
    equal(sorted(live.insert(points[:28])), range(28))
    live.commit()
    live = pbw.Live(np.empty((0, 3)))
    equal(live.npoints, 0)
    equal(live.insert(np.eye(4, 3)), range(4))
    equal(live.commit().made.shape, (1, 4))
    stop = threading.Event()

    def progress(stage, done):
        if stop.is_set():
            raise KeyError(stage)
    live = pbw.Live(points, progress=progress)
    live.insert(points / 2)
    stop.set()
    raises(KeyError, live.commit)
    stop.clear()
    equal(live.npoints, 30)
    live.commit()                                                         # they are still queued
    equal(live.npoints, 60)
    same_as_anew(live)


@test
def points_that_live_and_an_interrupt():
    points = np.random.default_rng(2).random((1500, 2))
    interrupt, ended = threading.Event(), threading.Event()

    def progress(stage, done):
        if interrupt.is_set():
            interrupt.clear()
            _thread.interrupt_main()
            ended.wait(600)                                               # longer than the interrupted call waits
    live = pbw.Live(points, progress=progress)
    live.insert(points + 2)
    interrupt.set()
    raises(KeyboardInterrupt, live.commit)
    threading.Timer(0.2, ended.set).start()
    live.insert(points[:9] + 4)                                           # waits for the thread that still works
    live.commit()
    equal(live.npoints, 3009)
    same_as_anew(live)
    refused = []

    def reenter(stage, done):
        if not refused:
            try:
                again.commit()
            except RuntimeError as e:
                refused.append(str(e))
    refused.append("not yet")
    again = pbw.Live(points, progress=reenter)
    refused.clear()
    again.insert(points + 2)
    again.commit()
    check("in use by the call" in refused[0], refused)


@test
def points_that_live_and_threads():
    live, failed = pbw.Live(np.random.default_rng(3).random((1200, 2))), []

    def work(seed):
        random = np.random.default_rng(seed)
        try:
            for _ in range(12):
                live.insert(random.random((30, 2)) + seed)
                live.commit()
                simplices = live.simplices
                check(simplices.max() < live.npoints and len(live.find_simplex(random.random((20, 2)))) == 20)
        except BaseException as e:
            failed.append(e)
    threads = [threading.Thread(target=work, args=(seed,)) for seed in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    check(not failed, failed)
    equal(live.npoints, 1200 + 4 * 12 * 30)
    same_as_anew(live)


@test
def pickles_that_are_damaged():
    points = np.random.default_rng(4).random((60, 3))
    for weights in (None, np.random.default_rng(5).random(60)):
        state = pbw.Delaunay(points, weights=weights)._mesh.__getstate__()
        again = pbw._library.Mesh.__new__(pbw._library.Mesh).__setstate__
        again(state)
        random = np.random.default_rng(6)
        for name in ("simplices", "neighbors", "incident", "canonical", "points", "weights"):
            if state[name] is None:
                continue
            for value in (-2 ** 31, -7, 2 ** 31 - 1, len(state[name]), 1):
                changed = state[name].copy()
                changed.reshape(-1)[random.integers(0, changed.size)] = value if name != "points" else np.nan
                if not np.array_equal(changed, state[name]) and name != "weights":
                    raises_text(ValueError, "damaged|finite", again, {**state, name: changed})
            for changed in (state[name][:-1], state[name].astype(np.float32), state[name].tolist(), "no", None):
                if name != "weights" or changed is not None:
                    raises(ValueError, again, {**state, name: changed})
            raises(ValueError, again, {key: value for key, value in state.items() if key != name})


@test
def progress():
    points = np.random.default_rng(9).random((100000, 3))
    calls = []
    tri = pbw.Delaunay(points, progress=lambda stage, done: calls.append((stage, done)))
    check(calls and {stage for stage, _ in calls} <= {"order", "build", "output"})
    check(all(0 <= done <= 1 for _, done in calls))

    def stop(stage, done):
        if stage == "build":
            raise KeyError("enough")

    raises(KeyError, pbw.Delaunay, points, progress=stop)


@test
def interruption():
    """The callback returns once the interruption has come out of the call, however long that takes."""
    points, reached, out = np.random.default_rng(9).random((100000, 3)), [], threading.Event()

    def interrupt(stage, done):
        reached.append(stage)
        os.kill(os.getpid(), signal.SIGINT)
        out.wait()

    before = set(threading.enumerate())
    signal.signal(signal.SIGINT, signal.default_int_handler)   # ignored in jobs of a shell that run in the background
    try:
        raises(KeyboardInterrupt, pbw.Delaunay, points, progress=interrupt)
    finally:
        out.set()
    for thread in set(threading.enumerate()) - before:
        thread.join()
    equal(len(reached), 1)             # the library was told to stop, and asked no more


@test
def several_at_once():
    points = [np.random.default_rng(k).random((20000, 3)) for k in range(4)]
    want = [pbw.Delaunay(p).simplices for p in points]
    got = [None] * 4

    def work(k):
        got[k] = pbw.Delaunay(points[k]).simplices

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for a, b in zip(want, got):
        equal(a, b)
    equal(pbw.Delaunay(points[0], threads=1).simplices, pbw.Delaunay(points[0], threads=3).simplices)


def command(*words, **environment):
    """The exit status of a Python command, and all that it prints; it sees no library and no package of ours."""
    kept = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "PBW_LIBRARY")}
    done = subprocess.run([sys.executable, *words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          env={**kept, "PYTHONDONTWRITEBYTECODE": "1", **environment})
    return done.returncode, done.stdout.decode()


@test
def installed_by_pip():
    """From the source tree, by a compiler that looks at the sources and hands over the library that is compiled already;
    and, but with QUICK, from a source archive, compiled there.  Without network."""
    if command("-m", "pip", "--version")[0] != 0:
        raise Skip("no pip")
    points = np.random.default_rng(13).random((50, 3))
    code = "import numpy, pbw; print(pbw.__file__, pbw.Delaunay(numpy.load('points.npy')).simplices.tolist())"
    with tempfile.TemporaryDirectory() as folder:
        np.save(os.path.join(folder, "points.npy"), points)
        status, said = command("-c", "import build; build.build_sdist(%r)" % folder, PYTHONPATH="examples/python")
        check(status == 0, said)
        archive = os.path.join(folder, "pbw-%s.tar.gz" % pbw.__version__)
        compiler = os.environ.get("CC") or "cc"
        with open(os.path.join(folder, "quick.sh"), "w") as file:
            file.write("%s -fsyntax-only \"$@\" || exit 1\nwhile [ $# != 0 ]; do\n"
                       "    [ $1 != -o ] || exec cp '%s' $2\n    shift\ndone\n"
                       % (compiler, os.path.abspath(os.environ["PBW_LIBRARY"])))
        ways = [("./examples/python", "sh " + file.name), (archive, compiler)]
        for source, compiler in ways[:1 if os.environ.get("QUICK") else 2]:
            site = os.path.join(folder, "site" + str(source == archive))
            status, said = command("-m", "pip", "install", "--no-index", "--no-deps", "--no-warn-script-location",
                                   "--target", site, source, CC=compiler, CFLAGS="-O0 -DPBW_NO_SIMD")
            check(status == 0, said)
            status, said = command("-c", "import os; os.chdir(%r); %s" % (folder, code), PYTHONPATH=site)
            equal(said.split(None, 1), [os.path.join(site, "pbw", "__init__.py"),
                                        "%s\n" % pbw.Delaunay(points).simplices.tolist()])


@test
def wheel_that_cannot_be_built():
    with tempfile.TemporaryDirectory() as folder:
        check("no C compiler: no-such-cc" in command("examples/python/build.py", folder, CC="no-such-cc -O2")[1])
        check("the C compiler failed" in command("examples/python/build.py", folder, CFLAGS="-ffast-math")[1])
        shutil.copytree("examples/python", os.path.join(folder, "alone"))
        check("from the whole source tree" in command(os.path.join(folder, "alone", "build.py"), folder)[1])
        equal(os.listdir(folder), ["alone"])


def run_examples(text, made="Delaunay("):
    """The code of a docstring, with our classes for SciPy's; what is printed that has one answer is compared."""
    stand_in = types.ModuleType("scipy.spatial")
    stand_in.Delaunay, stand_in.tsearch, stand_in.delaunay_plot_2d = pbw.Delaunay, pbw.tsearch, lambda tri: None
    stand_in.Voronoi, stand_in.voronoi_plot_2d = pbw.Voronoi, lambda vor: None
    plot = unittest.mock.MagicMock()
    with unittest.mock.patch.dict(sys.modules, {"scipy.spatial": stand_in, "matplotlib": plot,
                                                "matplotlib.pyplot": plot}):
        names = {"np": np}
        examples = doctest.DocTestParser().get_examples(text)
        for example in examples:
            exec(compile(example.source, example.source, "exec"), names)
    check(any(made in e.source for e in examples))
    return names


@with_scipy
def scipy_docstrings():
    names = run_examples(scipy.spatial.Delaunay.__doc__)
    check(isinstance(names["tri"], pbw.Delaunay) and names["b"].shape == (2, 3))
    names = run_examples(scipy.spatial.tsearch.__doc__)
    check(isinstance(names["tri"], pbw.Delaunay))
    names = run_examples(scipy.spatial.Voronoi.__doc__, "Voronoi(")
    check(isinstance(names["vor"], pbw.Voronoi) and isinstance(names["vor"], scipy.spatial.Voronoi))


@with_scipy
def scipy_finds_the_same_nearest():
    for dim in (2, 3):
        rng = np.random.default_rng(dim)
        points, q = rng.random((3000, dim)), rng.random((20, 50, dim)) * 1.4 - 0.2
        for k in (1, 8):
            ours, theirs = pbw.Delaunay(points).nearest(q, k), scipy.spatial.cKDTree(points).query(q, k)
            check(np.allclose(ours[0], theirs[0], rtol=1e-14))
            equal(ours[1], theirs[1])


@with_scipy
def scipy_has_the_same_voronoi_diagram():
    for dim in (2, 3):
        points = np.random.default_rng(dim).random((200, dim))
        ours, theirs = pbw.Voronoi(points), scipy.spatial.Voronoi(points)
        check(len(ours.vertices) == len(theirs.vertices) and len(ours.regions[0]) == 0)
        distance, number = scipy.spatial.cKDTree(theirs.vertices).query(ours.vertices)
        check((distance <= 1e-9 * np.maximum(1, np.abs(ours.vertices).max(axis=1))).all())
        check(len(set(number.tolist())) == len(number))
        number = {-1: -1, **dict(enumerate(number.tolist()))}
        pairs = np.sort(theirs.ridge_points, axis=1).tolist()
        known = dict(zip(map(tuple, pairs), theirs.ridge_vertices))
        check(known.keys() <= ours.ridge_dict.keys())
        for pair, ridge in ours.ridge_dict.items():
            if pair not in known:      # Qhull has no ridge that is a wedge, from one vertex to infinity
                check(dim == 3 and len(ridge) == 2 and -1 in ridge, ridge)
                continue
            ridge, other = [number[v] for v in ridge], known[pair]
            turns = [ridge[k:] + ridge[:k] for k in range(len(ridge))]
            check(other in turns or other[::-1] in turns, ridge, other)
        for i in range(200):
            check({number[v] for v in ours.regions[ours.point_region[i]]}
                  == set(theirs.regions[theirs.point_region[i]]))


@with_scipy
def scipy_tests_of_its_own():
    """Those that make a Delaunay object, but for a written list; see python_scipy.py."""
    import python_scipy
    try:
        passed, listed, faults, printed = python_scipy.run()
    except ImportError as e:
        raise Skip(e)
    check(not faults, "\n".join(faults))
    check(passed > 30 and listed > 5, printed[-1000:])
    print("    SciPy %s: %d of its tests pass, %d fail as listed" % (scipy.__version__, passed, listed))


@with_scipy
def scipy_gives_the_same():
    for dim in (2, 3):
        for seed in range(3):
            rng = np.random.default_rng(seed)
            points, q = rng.random((600, dim)), rng.random((1000, dim)) * 1.2 - 0.1
            ours, theirs = pbw.Delaunay(points), scipy.spatial.Delaunay(points)
            check(sets(ours.simplices) == sets(theirs.simplices))
            check(sets(ours.convex_hull) == sets(theirs.convex_hull))
            equal(ours.coplanar.shape, theirs.coplanar.shape)
            equal([ours.ndim, ours.npoints, ours.nsimplex], [theirs.ndim, theirs.npoints, theirs.nsimplex])
            equal([ours.min_bound, ours.max_bound], [theirs.min_bound, theirs.max_bound])
            for name in ("simplices", "neighbors", "convex_hull", "coplanar", "vertex_to_simplex", "transform",
                         "equations"):
                a, b = getattr(ours, name), getattr(theirs, name)
                check(a.dtype == b.dtype and a.shape == b.shape, name, a.dtype, b.dtype, a.shape, b.shape)
            a, b = ours.vertex_neighbor_vertices, theirs.vertex_neighbor_vertices
            equal(a[0], b[0])
            check(a[1].dtype == b[1].dtype)
            for p in range(len(points)):
                equal(a[1][a[0][p]:a[0][p + 1]], np.sort(b[1][b[0][p]:b[0][p + 1]]))
            # simplex by simplex: which of theirs is ours, and at which of its corners each of our corners is
            order = np.argsort(ours.simplices, axis=1)
            rows = {row: t for t, row in enumerate(map(tuple, np.sort(theirs.simplices, axis=1).tolist()))}
            same = np.array([rows[r] for r in map(tuple, np.take_along_axis(ours.simplices, order, 1).tolist())])
            back = np.argsort(same)
            corner = np.argsort(theirs.simplices[same], axis=1)
            a, b = np.take_along_axis(ours.neighbors, order, 1), np.take_along_axis(theirs.neighbors[same], corner, 1)
            equal(np.where(a >= 0, same[a], -1), b)
            a, b = ours.find_simplex(q), theirs.find_simplex(q)
            equal(np.where(a >= 0, same[a], -1), b)
            a, b = np.linalg.det(ours.transform[back][:, :dim]), np.linalg.det(theirs.transform[:, :dim])
            check(np.allclose(np.abs(a), np.abs(b), rtol=1e-5))
            a, b = ours.plane_distance(q)[:, back], theirs.plane_distance(q)
            check((np.sign(a) == np.sign(b))[(np.abs(a) > 1e-9) & (np.abs(b) > 1e-9)].all())
            check(((theirs.equations[:, -2] < 0) == (ours.equations[:, -2] < 0)).all())


@with_scipy
def scipy_reports_the_same_duplicates():
    rng = np.random.default_rng(11)
    for dim in (2, 3):
        points = rng.random((200, dim))
        points = np.concatenate([points, points[:50]])
        ours, theirs = pbw.Delaunay(points), scipy.spatial.Delaunay(points)
        pairs = {tuple(sorted(row)) for row in theirs.coplanar[:, [0, 2]].tolist()}
        check(sets(ours.coplanar[:, [0, 2]]) == pairs)
        for p, t, v in ours.coplanar:
            check(v in ours.simplices[t] and ours.vertex_to_simplex[p] == t)


@with_scipy
def scipy_interpolates_on_ours():
    from scipy.interpolate import CloughTocher2DInterpolator, LinearNDInterpolator
    rng = np.random.default_rng(12)
    for dim, interpolator in ((2, LinearNDInterpolator), (3, LinearNDInterpolator), (2, CloughTocher2DInterpolator)):
        points, values, q = rng.random((400, dim)), rng.random(400), rng.random((2000, dim)) * 1.2 - 0.1
        tri = pbw.Delaunay(points)
        ours, theirs = interpolator(tri, values)(q), interpolator(points, values)(q)
        check(np.isnan(ours).any() and np.isfinite(ours).any())
        check(np.allclose(ours, theirs, rtol=1e-5, atol=1e-5, equal_nan=True))
        again = interpolator(pickle.loads(pickle.dumps(tri)), values)(q)
        equal(np.nan_to_num(again), np.nan_to_num(ours))
        lattice = np.array(list(itertools.product(range(5), repeat=dim)), float)      # any triangulation is right
        inside = rng.random((500, dim)) * 4
        linear = interpolator(pbw.Delaunay(np.concatenate([lattice, lattice[:9]])),
                              np.concatenate([lattice, lattice[:9]]).sum(axis=1))
        check(np.allclose(linear(inside), inside.sum(axis=1)))


@with_scipy
def scipy_takes_ours_for_its_own():
    class Mine(pbw.Delaunay):
        pass

    for cls in (pbw.Delaunay, Mine):
        tri = cls([[0, 0], [1, 0], [0, 1], [3, 3]])
        for each in (tri, copy.copy(tri), copy.deepcopy(tri), tri.__class__(tri.points)):
            check(isinstance(each, scipy.spatial.Delaunay) and isinstance(each, cls))
            check(isinstance(type(each).find_simplex, types.FunctionType))
            equal(scipy.spatial.tsearch(each, [[0.1, 0.1], [-1, 0]]), [each.find_simplex([0.1, 0.1]), -1])
    equal(type(pickle.loads(pickle.dumps(pbw.Delaunay(tri.points).__class__(tri.points)))), pbw.Delaunay)
    error = raises(scipy.spatial.QhullError, pbw.Delaunay, np.zeros((5, 2)))
    check(isinstance(error, pbw.Error) and type(pickle.loads(pickle.dumps(error))) is pbw.Error)


# ---- plane domains


def plane_areas(vertices, triangles):
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    u, v = b - a, c - a
    return (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / 2


def plane_angles(vertices, triangles):
    p = vertices[triangles]
    angles = []
    for k in range(3):
        u, v = p[:, (k + 1) % 3] - p[:, k], p[:, (k + 2) % 3] - p[:, k]
        angles.append(np.degrees(np.arctan2(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0], (u * v).sum(axis=1))))
    return np.array(angles)


PLATE = dict(vertices=[[0, 0], [4, 0], [4, 3], [0, 3], [1, 1], [2, 1], [2, 2], [1, 2], [3, 0], [3, 3]],
             segments=[[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [8, 9]],
             segment_markers=[[5], [6], [7], [8], [9], [9], [9], [9], [0]],
             holes=[[1.5, 1.5]], regions=[[0.5, 0.5, 10, 0.05], [3.5, 0.5, 20, 0.2]])


@test
def test_triangulate():
    made = pbw.triangulate(PLATE, "p")
    assert abs(plane_areas(made["vertices"], made["triangles"]).sum() - 11) < 1e-12
    assert len(made["vertices"]) == 10 and len(made["segments"]) == 11
    assert sorted(set(made["segment_markers"].ravel())) == [0, 5, 6, 7, 8, 9]
    made = pbw.triangulate(PLATE, "pq30a0.1AenQ")
    areas = plane_areas(made["vertices"], made["triangles"])
    assert abs(areas.sum() - 11) < 1e-12 and areas.max() <= 0.1 * 1.0001
    assert plane_angles(made["vertices"], made["triangles"]).min() > 30 - 1e-9
    left = made["vertices"][made["triangles"]].mean(axis=1)[:, 0] < 3
    assert (made["triangle_attributes"].ravel() == np.where(left, 10, 20)).all()
    edges, count = made["edges"], len(made["vertices"])
    assert count - len(edges) + len(made["triangles"]) == 0              # Euler, one hole
    assert made["neighbors"].shape == made["triangles"].shape
    regions = pbw.triangulate(PLATE, "pqa")
    areas = plane_areas(regions["vertices"], regions["triangles"])
    left = regions["vertices"][regions["triangles"]].mean(axis=1)[:, 0] < 3
    assert areas[left].max() <= 0.05 * 1.0001 and 0.05 < areas[~left].max() <= 0.2 * 1.0001
    assert abs(plane_areas(*[pbw.triangulate(PLATE, "pc")[k] for k in ("vertices", "triangles")]).sum() - 11) < 1e-12


@test
def triangulate_keeps_regions_of_triangles():
    """A mesh with turned triangles, regions of two attributes each, a line inside a region and a marked border."""
    x, y = (array.ravel() for array in np.meshgrid(np.arange(7.0), np.arange(4.0)))
    x = x + 0.2 * ((y > 0) & (y < 3) & (x % 3 > 0))
    lower = np.array([i + 7 * j for j in range(3) for i in range(6)])
    triangles = np.concatenate([np.stack([lower, lower + 1, lower + 7], axis=1),
                                np.stack([lower + 7, lower + 8, lower + 1], axis=1)])
    left = x[triangles].mean(axis=1) < 3
    mesh = dict(vertices=np.stack([x, y], axis=1), triangles=triangles, vertex_attributes=5 * x - y,
                triangle_attributes=np.where(left[:, None], [[6.5, 1]], [[-8, 1]]),
                segments=[[i, i + 1] for i in range(6)] + [[8, 9]], segment_markers=[4] * 6 + [5])

    def check_mesh(made):
        points, sides = made["vertices"], made["vertices"][made["segments"]]
        areas = plane_areas(points, made["triangles"])
        there = points[made["triangles"]]
        kinds = made["triangle_attributes"]
        assert (areas > 0).all() and not ((there[:, :, 0].min(axis=1) < 3) & (there[:, :, 0].max(axis=1) > 3)).any()
        assert (kinds == np.where(there.mean(axis=1)[:, :1] < 3, [[6.5, 1]], [[-8, 1]])).all()
        lengths = np.hypot(*(sides[:, 1] - sides[:, 0]).T)
        for marker, length in ((4, 6), (5, 1)):
            assert abs(lengths[made["segment_markers"].ravel() == marker].sum() - length) < 1e-12
        assert abs(areas.sum() - 18) < 1e-12 and abs(made["vertex_attributes"][:, 0] - points @ [5, -1]).max() < 1e-12

    for options, smooth in (("r", None), ("rq30a0.05", None), ("rpq", "odt"), ("r", "lloyd"), ("rA", "laplace")):
        made = pbw.triangulate(mesh, options, smooth=smooth)
        check_mesh(made)
        assert (len(made["vertices"]) > 28) == ("a" in options), options
    moved = (made["vertices"] != mesh["vertices"]).any(axis=1)
    assert moved.any() and not moved[[8, 9, *range(7), 10, 17]].any()
    assert "triangle_attributes" not in pbw.triangulate(dict(mesh, triangle_attributes=None), "r")
    raises_text(ValueError, "the switch r needs triangles", pbw.triangulate, PLATE, "r")
    raises_text(ValueError, "smooth must be None, 'laplace' or", pbw.triangulate, mesh, "r", smooth="best")
    over = dict(mesh, triangles=np.concatenate([triangles, [[0, 6, 27]]]), triangle_attributes=None)
    check("on each other" in str(raises(ValueError, pbw.triangulate, over, "r")))


@test
def triangulate_keeps_attributes_and_markers():
    given = dict(PLATE, vertex_attributes=[[x + 10 * y, x * x] for x, y in PLATE["vertices"]],
                 vertex_markers=[[3]] + [[0]] * 8 + [[-4]])
    made = pbw.triangulate(given, "pq30a0.1j")
    x, y = made["vertices"].T
    attributes, markers = made["vertex_attributes"], made["vertex_markers"].ravel()
    assert len(x) > 50 and np.abs(attributes[:, 0] - x - 10 * y).max() < 1e-12
    assert (attributes[:10] == given["vertex_attributes"]).all()
    bottom = (y == 0) & (x > 0)                          # segment 0, of marker 5
    assert (markers[bottom] == 5).all() and markers[0] == 3 and markers[9] == -4
    on = (attributes[:, 1] - x * x > -1e-12) & (y == 0)   # along a segment the second one is linear between its ends
    assert np.abs(attributes[on & (x < 3), 1] - 3 * x[on & (x < 3)]).max() < 1e-12
    inside = (x > 2.2) & (x < 2.8) & (y > 0) & (y < 3)
    assert inside.any() and (markers[inside] == 0).all()
    hole = (x >= 1) & (x <= 2) & (y >= 1) & (y <= 2)
    assert (markers[hole] == 9).all() and made["segment_markers"].shape == (len(made["segments"]), 1)
    plain = pbw.triangulate(dict(vertices=PLATE["vertices"], segments=PLATE["segments"]), "pq30a0.1")
    assert "vertex_attributes" not in plain and set(plain["vertex_markers"].ravel()) == {0, 1}
    cross = dict(vertices=[[0, 0], [4, 4], [4, 0], [0, 4]], segments=[[0, 1], [2, 3]],
                 vertex_attributes=[0, 4, 10, 20])
    made = pbw.triangulate(cross, "pc", split_crossings=True)
    assert made["vertex_attributes"].ravel().tolist() == [0, 4, 10, 20, 8.5]
    raises_text(ValueError, r"vertex_markers must have 10 rows of 1 number, not the shape \(1, 1\)", pbw.triangulate,
                dict(PLATE, vertex_markers=[[1]]), "p")


@test
def too_many_triangles():
    raises_text(ValueError, "triangles, more than most = 50000000 allows", pbw.triangulate, PLATE, "pa1e-160")
    raises_text(ValueError, "triangles, more than most = 1000 allows", pbw.triangulate, PLATE, "pqa0.001", most=1000)
    raises_text(ValueError, "most must be above 0, not nan", pbw.triangulate, PLATE, "pq", most=float("nan"))
    check(len(pbw.triangulate(PLATE, "pqa0.01", most=3000)["triangles"]) > 1000)


@test
def nothing_enclosed():
    points = [[0, 0], [4, 0], [4, 4], [0, 4]]
    raises_text(pbw.Error, r"nothing is enclosed: segments end where no other goes on, at vertex 0 \(0, 0\), "
                r"vertex 3 \(0, 4\); close the outline, or the switch c triangulates all", pbw.triangulate,
                dict(vertices=points, segments=[[0, 1], [1, 2], [2, 3]]), "p")
    raises_text(pbw.Error, "nothing is enclosed, there are no segments: leave out the switch p, or add c",
                pbw.triangulate, dict(vertices=points), "p")
    raises_text(pbw.Error, "nothing is enclosed: holes, or rings that lie on each other, take all; the switch c "
                "triangulates all", pbw.triangulate,
                dict(vertices=points, segments=[[0, 1], [1, 2], [2, 3], [3, 0]], holes=[[1, 1]]), "p")
    raises_text(pbw.Error, "nothing is enclosed: rings that lie on each other take all", pbw.polygon,
                [points, points])


@test
def test_triangulate_refuses():
    crossing = dict(vertices=[[0, 0], [1, 1], [1, 0], [0, 1]], segments=[[0, 1], [2, 3]])
    for data, options, text in ((PLATE, "pk", "no switch"), (PLATE, "pq40", "34 degrees"), (crossing, "p", "cross"),
                                (dict(vertices=[[0, 0], [1, 1]], segments=[[0, 2]]), "p", "last vertex"),
                                (dict(vertices=[[0, 0, 0]]), "", "2D")):
        try:
            pbw.triangulate(data, options)
        except ValueError as e:
            assert text in str(e), e
        else:
            raise AssertionError(options)
    assert len(pbw.triangulate(crossing, "pc", split_crossings=True)["vertices"]) == 5
    raises_text(ValueError, "data must have vertices; it has 'segments'", pbw.triangulate, {"segments": []})


@test
def test_polygon():
    turn = np.linspace(0, 2 * np.pi, 100, endpoint=False)
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    vertices, triangles = pbw.polygon([2 * ring, ring, 0.5 * ring[::-1]])
    areas = plane_areas(vertices, triangles)
    unit = 50 * np.sin(2 * np.pi / 100)
    assert len(vertices) == 300 and (areas > 0).all() and abs(areas.sum() - unit * (4 - 1 + 0.25)) < 1e-12


def volumes(mesh):
    a, b, c, d = np.moveaxis(mesh.points[mesh.tets], 1, 0)
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6


@test
def improved_tetrahedra():
    points = np.random.RandomState(1).rand(400, 3)
    tri = pbw.Delaunay(points)
    better = pbw.improve(points, tri.simplices)
    check(re.fullmatch(r"<pbw.Tets: %d tetrahedra, %d points, dihedral angles from .* to .* degrees>"
                       % (len(better.tets), len(better.points)), repr(better)))
    raises_text(ValueError, "target must be from 1 to 60, not 61", pbw.improve, points, tri.simplices, target=61)
    before, after = better.report["before"], better.report["after"]
    check(after["least_sine"] >= before["least_sine"] and after["permille"] > 4 * before["permille"], before, after)
    check((volumes(better) > 0).all() and abs(volumes(better).sum() - after["volume"]) < 1e-12)
    check(sorted(set(better.tets.ravel())) == list(range(len(better.points))))
    kept = pbw.improve(points, tri.simplices, fixed=np.ones(400, bool), regions=np.arange(len(tri.simplices)) % 2,
                       seconds=0.5)
    kept_points = kept.original >= 0
    equal(kept.points[kept_points], points[kept.original[kept_points]])
    check(set(kept.regions) == {0, 1})
    check("range" in str(raises(ValueError, pbw.improve, points, [[0, 1, 2, 2]])))
    raises(ValueError, pbw.improve, points, [[0, 1, 2, 400]])
    raises(ValueError, pbw.improve, points, tri.simplices, regions=[1])
    for smooth in "odt", "lloyd", "laplace":
        moved = pbw.improve(points, tri.simplices, target=None, smooth=smooth, rounds=3)
        equal(np.sort(moved.original[moved.tets]), np.sort(tri.simplices))
        report = moved.report
        check(report["moves"] > 100 and report["rounds"] == 3 and report["passes"] == 0, report)
    check("lloyd" in str(raises(ValueError, pbw.improve, points, tri.simplices, smooth="best")))


def areas(mesh, patch):
    a, b, c = np.moveaxis(mesh.points[mesh.facets[mesh.patches == patch]], 1, 0)
    return np.cross(b - a, c - a) / 2


@test
def faults_of_surfaces():
    cube = np.array(list(itertools.product((0.0, 1.0), repeat=3)))
    hull = pbw.Delaunay(cube).convex_hull
    clean = pbw.check_surface(cube, hull)
    assert not clean and "0 pairs" in repr(clean) and clean.segments.shape == (0, 2, 3)
    moved = pbw.check_surface(np.concatenate([cube, cube + 0.5]), np.concatenate([hull, hull + 8]), threads=2)
    assert moved and len(moved.crossings) > 0 and not len(moved.edges)
    assert (moved.crossings[:, 0] < 12).all() and (moved.crossings[:, 1] >= 12).all()
    assert (moved.segments >= 0.5).all() and (moved.segments <= 1).all()
    soup = pbw.check_surface(cube[hull].reshape(-1, 3), np.arange(36).reshape(12, 3))      # corners of their own
    assert not soup and len(soup.repeated) == 28 and (soup.repeated[:, 0] > soup.repeated[:, 1]).all()
    bad = pbw.check_surface(cube, np.concatenate([hull[1:], hull[1:2], [[0, 0, 1]]]))
    assert bad.duplicates.tolist() == [[11, 0]] and bad.flat.tolist() == [12]
    opened = pbw.check_surface(cube, hull[1:])
    equal(opened.edge_triangles, np.ones(3))
    equal(np.unique(opened.edges), np.sort(hull[0]))
    assert not pbw.check_surface(np.empty((0, 3)), np.empty((0, 3), int))
    raises_text(ValueError, "triangles must be whole numbers from 0 to 7", pbw.check_surface, cube, [[0, 1, 8]])
    raises(ValueError, pbw.check_surface, cube * np.nan, hull)


@test
def fill_keeps_faces():
    cube = np.array(list(itertools.product((0.0, 1.0), repeat=3)))
    hull = pbw.Delaunay(cube).convex_hull
    two = np.vstack([cube, cube + [1, 0, 0]])
    made = pbw.fill(two, np.vstack([hull, hull + 8]), seeds=[[.5, .5, .25], [1.5, .5, .25]],
                    seed_regions=[5, 2])
    check(made.report["doubles"] in (0, 2) and set(made.regions) == {2, 5}, made.report)
    for region in 2, 5:
        check(abs(volumes(made)[made.regions == region].sum() - 1) < 1e-12)
    check(set(map(tuple, np.sort(made.sides[made.sides[:, 1] >= 0], axis=1).tolist())) == {(2, 5)})
    check(len(made.facets) == 24 - made.report["doubles"] and made.report["refusal"] == 0)
    check(len(pbw.fill(cube, hull, conforming=True, split_flat=True).facets) >= 12)
    ball = np.random.default_rng(1).normal(size=(60, 3))
    ball /= np.linalg.norm(ball, axis=1)[:, None]
    skin = pbw.Delaunay(ball).convex_hull
    better = pbw.fill(ball, skin, target=20)
    equal(np.sort(np.sort(better.original[better.facets], axis=1), axis=0),
          np.sort(np.sort(skin[better.facet_triangle], axis=1), axis=0))
    check(better.report["improve"]["after"]["least"] > better.report["improve"]["before"]["least"])
    names = np.where(cube[hull].mean(axis=1)[:, 0] == 0, "inlet", "wall")
    made = pbw.fill(cube, hull, numbers=names)
    found = areas(made, "inlet")
    check(abs(found.sum(axis=0) - [-1, 0, 0]).max() < 1e-12, found)
    check("open" in str(raises(pbw.Error, pbw.fill, cube, hull[:-1])))
    check("cross" in str(raises(pbw.Error, pbw.fill, np.vstack([cube, cube + 0.5]), np.vstack([hull, hull + 8]))))
    raises(ValueError, pbw.fill, cube, hull, seeds=[[.5, .5, .5]], seed_regions=[1, 2])
    raises_text(ValueError, "gradation is for ratio", pbw.fill, cube, hull, size=0.3, gradation=0.2)
    made = pbw.fill(two, np.vstack([hull, hull + 8]), seeds=[[.5, .5, .25], [1.5, .5, .25]],
                    seed_regions=["steel", "air"], volume={"air": 0.002})
    sizes = {name: volumes(made)[made.regions == name] for name in ("air", "steel")}
    check(set(made.regions) == {"air", "steel"}, set(made.regions))
    check(len(sizes["air"]) > 2 * len(sizes["steel"]) and np.median(sizes["air"]) < np.median(sizes["steel"]), sizes)
    fine = pbw.fill(ball, skin, size=0.15)
    coarse = pbw.fill(ball, skin, size=lambda p: 0.15 if p[0] > 0 else 0.5)
    graded = pbw.fill(ball, skin, ratio=1.5)
    check(len(fine.tets) > 1.5 * len(coarse.tets) > 2 * len(graded.tets), len(fine.tets), len(coarse.tets))
    check(all(len(made.facets) == len(skin) and (volumes(made) > 0).all() for made in (fine, coarse, graded)))
    check(raises(ZeroDivisionError, pbw.fill, ball, skin, size=lambda p: 1 / 0))
    raises(ValueError, pbw.fill, ball, skin, size=-1)
    raises(ValueError, pbw.fill, ball, skin, volume={1: 0.1})


@test
def names_go_through_solid_and_improve():
    cube = np.array(list(itertools.product((0.0, 1.0), repeat=3)))
    hull = pbw.Delaunay(cube).convex_hull
    x = cube[hull].mean(axis=1)[:, 0]
    names = np.where(x == 0, "inlet", np.where(x == 1, "outlet", "wall"))
    for label in lambda one: one, {"inlet": 7, "outlet": -3, "wall": 2 ** 40}.get:
        labels = [label(one) for one in names]
        made = pbw.solid(cube, hull, size=0.5, patches=labels)
        half = np.where(made.points[made.tets].mean(axis=1)[:, 2] > 0.5, "top", "bottom")
        ends = made.points[made.edges]
        groups = np.where((ends[:, :, 0] == 0).all(axis=1), label("inlet"), label("wall"))
        better = pbw.improve(made.points, made.tets, regions=half, facets=made.facets, patches=made.patches,
                             edges=made.edges, edge_groups=groups, sizes=np.full(len(made.points), 0.17))
        check(len(better.tets) > 2 * len(made.tets) and len(better.edges) > len(made.edges), better)
        check(len(np.unique(made.parts)) == 6 and len(np.unique(made.parts[made.patches == label("wall")])) == 4)
        for mesh in made, better:
            for name, area in ("inlet", [-1, 0, 0]), ("outlet", [1, 0, 0]), ("wall", [0, 0, 0]):
                found = areas(mesh, label(name))
                check(abs(found.sum(axis=0) - area).max() < 1e-12, name, found.sum(axis=0))
                check(abs(np.linalg.norm(found, axis=1).sum() - (4 if name == "wall" else 1)) < 1e-12, name)
        outside = better.sides[:, 1] == ""
        check(set(better.patches[~outside]) == {"" if label("wall") == "wall" else -1})
        check(set(map(tuple, np.sort(better.sides[~outside], axis=1).tolist())) == {("bottom", "top")})
        check(set(better.regions) == {"top", "bottom"})
        for name in "bottom", "top":
            check(abs(volumes(better)[better.regions == name].sum() - volumes(made)[half == name].sum()) < 0.02)
        length = np.linalg.norm(np.diff(better.points[better.edges], axis=1)[:, 0], axis=1)
        inlet = (better.points[better.edges][:, :, 0] == 0).all(axis=1)
        equal(better.edge_groups, np.where(inlet, label("inlet"), label("wall")))
        check(abs(length.sum() - np.linalg.norm(np.diff(ends, axis=1)[:, 0], axis=1).sum()) < 1e-12)


@test
def facets_and_edges_inside():
    points = np.array(list(itertools.product(range(4), repeat=3)), float)
    tets = pbw.Delaunay(points).simplices
    middle = np.array([f for t in tets for f in itertools.combinations(t, 3) if (points[list(f), 0] == 2).all()])
    middle = np.unique(np.sort(middle, axis=1), axis=0)
    better = pbw.improve(points, tets, facets=middle, patches=np.full(len(middle), 5), edges=middle[:, :2])
    inside = better.patches == 5
    check(inside.sum() == len(middle) and (better.points[better.facets[inside], 0] == 2).all())
    check((better.sides[inside] == 0).all() and (better.sides[~inside] == [0, -1]).all())
    check((better.patches[~inside] == -1).all() and better.edge_groups is None)
    check(sets(better.original[better.facets[inside]]) == sets(middle))
    check(sets(better.original[better.edges]) == sets(np.unique(middle[:, :2], axis=0)))
    a, b, c = np.moveaxis(better.points[better.facets[~inside]], 1, 0)
    check((np.einsum("ij,ij->i", np.cross(b - a, c - a), a - 1.5) > 0).all(), "facets are turned outward")
    away = [[0, 1, 63]]
    for text, named in [
            (r"facets\[1\] is not in any tetrahedron", dict(facets=np.concatenate([middle[:1], away]))),
            (r"edges\[0\] is not in any tetrahedron", dict(edges=[[0, 63]])),
            (r"facets\[0\] is there again, and not in the same patch", dict(facets=middle[[0, 0]],
                                                                            patches=["a", "b"])),
            (r"edges\[1\] is there again, and not in the same group", dict(edges=middle[[0, 1, 1], :2],
                                                                          edge_groups=[1, 3, 2])),
            ("patches needs facets", dict(patches=[1])), ("edge_groups needs edges", dict(edge_groups=[1])),
            (r"patches has the shape \(1,\): 2 numbers or names", dict(facets=middle[:2], patches=[1])),
            ("patches must be whole numbers or names", dict(facets=middle[:1], patches=[0.5])),
            ("regions must be whole numbers or names", dict(regions=[None] * len(tets))),
            (r"facets must be whole numbers from 0 to 63", dict(facets=[[0, 1, 64]])),
            (r"facets has the shape \(1, 2\)", dict(facets=[[0, 1]])),
            (r"sizes has the shape \(2,\)", dict(sizes=[1, 2])), ("size", dict(sizes=np.zeros(64)))]:
        raises_text(ValueError, text, pbw.improve, points, tets, **named)
    whole = pbw.improve(points, tets, regions=np.arange(len(tets)) % 2 + 0.0)
    check(set(whole.regions) == {0, 1} and whole.regions.dtype == np.int64 and len(whole.edges) == 0)


@test
def holes_of_a_solid_have_no_name():
    cube = np.array(list(itertools.product((0.0, 1.0), repeat=3)))
    hull = pbw.Delaunay(cube).convex_hull
    open_above = hull[cube[hull].mean(axis=1)[:, 2] < 1]
    for label, none in ("side", ""), (3, -1):
        made = pbw.solid(cube, open_above, size=0.5, patches=[label] * len(open_above), close=True)
        check(set(made.patches) == {label, none}, made.patches)
        check((made.points[made.facets[made.patches == none], 2] == 1).all())
    raises_text(ValueError, "patches must be whole numbers or names", pbw.solid, cube, hull, patches=[0.5] * 12)
    raises_text(ValueError, "patches has the shape", pbw.solid, cube, hull, patches=["a"])


@test
def improved_files_of_meshio():
    try:
        import meshio
    except ImportError:
        raise Skip("no meshio")
    points = np.random.RandomState(2).rand(200, 3)
    mesh = meshio.Mesh(points, [("tetra", pbw.Delaunay(points).simplices)])
    with tempfile.TemporaryDirectory() as folder:
        for kind in "msh", "vtu", "mesh":
            path = os.path.join(folder, "a." + kind)
            mesh.write(path)
            read = meshio.read(path)
            better = pbw.improve(read.points, read.cells_dict["tetra"], seconds=0.2)
            meshio.Mesh(better.points, [("tetra", better.tets)]).write(path)
            again = meshio.read(path)
            equal(again.cells_dict["tetra"], better.tets)
            check(abs(again.points - better.points).max() < 1e-15)
            check(better.report["after"]["least_sine"] >= better.report["before"]["least_sine"])


@test
def solids():
    cube = np.array(list(itertools.product((0.0, 1.0), repeat=3)))
    hull = pbw.Delaunay(cube).convex_hull
    made = pbw.solid(cube, hull, size=0.25)
    check(repr(made).startswith("<pbw.Tets: %d tetrahedra, " % len(made.tets)))
    for name in "size", "least_size", "curvature", "around", "gradation":
        raises_text(ValueError, name + " must be from 0 to .*, not -1", pbw.solid, cube, hull, **{name: -1})
    raises_text(ValueError, "target must be from 1 to 60, not 90", pbw.solid, cube, hull, target=90)
    few, many = [len(pbw.solid(cube, hull, size=lambda p: min(0.08 + 0.5 * p[0], 0.2), gradation=g).tets)
                 for g in (0, 0.05)]
    check(many > 1.2 * few, few, many)
    few, many = [len(pbw.solid(cube, hull, size=0.3, region_sizes=sizes).tets) for sizes in (None, {0: 0.1})]
    check(many > 5 * few, few, many)
    raises_text(ValueError, "the size of a region must be from 0 to .*, not -1", pbw.solid, cube, hull,
                region_sizes={0: -1})
    report = made.report
    equal([report[name] for name in ("bad_edges", "bad_points", "missing_edges", "open_edges")], [0] * 4)
    check(report["euler"] == 2 and report["corners"] == 8 and abs(volumes(made).sum() - 1) < 1e-12, report)
    check(report["improve"]["after"]["least"] > 25 and (volumes(made) > 0).all(), report)
    check(len(np.unique(made.patches)) == 6 and (made.sides == [0, -1]).all() and len(made.edges) >= 48, report)
    nested = pbw.solid(np.concatenate([cube, cube * 0.4 + 0.3]), np.concatenate([hull, hull + 8]), nested=True,
                       size=lambda p: 0.3 if p[0] < 0.5 else 0.15, patches=[4] * 12 + [7] * 12)
    check(sorted(set(nested.regions)) == [0, 1] and sorted(set(nested.patches)) == [4, 7], nested.report)
    check(abs(volumes(nested)[nested.regions == 1].sum() - 0.064) < 1e-9, nested.report)
    even = len(pbw.solid(cube, hull, size=0.3).tets)
    same = len(pbw.solid(cube, hull, size=lambda p: 0.3).tets)
    check(0.5 * even < same < 2 * even, (even, same))
    open_ended = pbw.solid(cube, hull, size=lambda p: 0.15 if p[0] < 0.5 else np.inf)
    check(even < len(open_ended.tets) < 100 * even, len(open_ended.tets))
    raises(AttributeError, pbw.solid, cube, hull, size=lambda p: p.missing)
    raises_text(ValueError, "above 0 nowhere", pbw.solid, cube, hull, size=lambda p: 0)
    raises(pbw.Error, pbw.solid, cube, hull[:1], size=0.25)
    raises(ValueError, pbw.solid, cube, [[0, 1, 8]])


@test
def wraps():
    corners = np.array(list(itertools.product((0., 1.), repeat=3)))
    faces = np.array([[0, 1, 3], [0, 3, 2], [4, 7, 5], [4, 6, 7], [0, 5, 1], [0, 4, 5], [2, 3, 7], [2, 7, 6],
                      [1, 5, 7], [1, 7, 3], [0, 2, 6]])
    made = pbw.wrap(corners, faces, alpha=0.2)       # five sides and a half
    edges = np.concatenate([made.faces[:, [i, (i + 1) % 3]] for i in range(3)])
    equal(np.unique(edges, axis=0), np.unique(edges[:, ::-1], axis=0))
    check(len(np.unique(edges, axis=0)) == len(edges) and made.faces.max() + 1 == made.vertex_count)
    a, b, c, d = (made.points[made.tets[:, i]] for i in range(4))
    volume = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6
    check((volume > 0).all() and abs(volume.sum() - made.report["volume"]) < 1e-9, made.report)
    check((made.neighbors < 0).sum() == len(made.faces) == len(made.elements) and made.elements.max() < 11)
    check(made.report["shell"] == 1 and made.report["open_edges"] > 0, made.report)
    closed = pbw.wrap(corners, faces, alpha=0.2, closing=True).report["closing"]
    check(pbw.wrap(corners, faces, alpha=closed).report["shell"] == 0, closed)
    check(len(pbw.wrap(corners, faces, alpha=lambda p: 0.3 if p[0] > 0.5 else 0.1).faces) > 500)
    check(pbw.wrap(corners, segments=[[0, 1], [0, 2]], alpha=0.2).report["components"] == 1)
    check(pbw.wrap(corners, alpha=0.2).report["components"] == 8)
    seeded = pbw.wrap(corners, faces, alpha=0.5, offset=0.02, seeds=[[9, 9, 9]])
    check(seeded.report["unused_seeds"] == 1 and seeded.report["offset"] == 0.02, seeded.report)
    solid = pbw.solid(corners, faces, size=0.25, wrap=True)
    check(solid.report["after"]["least"] > 15 and solid.report["wrap"]["shell"] == 1, solid.report)
    smaller = np.concatenate([corners, [[.4, .5, 0]]]), np.concatenate([faces, [[0, 6, 8], [6, 4, 8]]])
    report = pbw.solid(*smaller, size=0.25, wrap=True).report          # an alpha of 0.125 does not close this hole
    check(report["wrap"]["shell"] == 0 and 0.125 < report["wrap"]["alpha"] < 0.19, report)
    check(report["closed"] == 0 and report["raised"] == 0.125 and report["distance_before"][1] > 0.03, report)
    check((solid.neighbors < 0).sum() == len(solid.facets) and solid.points.max() < 1.2, solid)
    solid = pbw.solid(corners, np.concatenate([faces, [[0, 6, 4]]]), size=0.25, wrap=True)
    report = solid.report
    away = np.abs(solid.points[np.unique(solid.facets)] - 0.5).max(1) - 0.5
    check((np.abs(away) < 1e-12).mean() > 0.7, away)                      # most points are on the cube
    check(report["closed"] == 1 and report["raised"] == 0 and abs(report["after"]["volume"] - 1) < 0.04, report)
    check(report["distance"][1] < report["distance_before"][1] and report["after"]["least"] > 29, report)
    raises_text(pbw.Error, "more tetrahedra", pbw.solid, corners, faces, wrap=True, most=10)
    raises_text(ValueError, "size must be a number", pbw.solid, corners, faces, size=len, wrap=True)
    raises_text(pbw.Error, "nothing to wrap", pbw.wrap, corners, singles=[])
    raises_text(pbw.Error, "at one place", pbw.wrap, corners[:1])
    raises_text(pbw.Error, "the offset", pbw.wrap, corners + 1e12, faces)
    raises_text(pbw.Error, "more tetrahedra", pbw.wrap, corners, faces, alpha=0.1, most=10)
    raises_text(ValueError, "alpha must be from 0 to .*, not -1", pbw.wrap, corners, faces, alpha=-1)
    raises(ValueError, pbw.wrap, corners, [[0, 1, 8]])
    raises(AttributeError, pbw.wrap, corners, faces, alpha=lambda p: p.missing)


def main():
    passed = failed = skipped = 0
    for function in tests:
        name = function.__name__.replace("_", " ")
        if scipy is None and hasattr(function, "needs_scipy"):
            skipped += 1
            print("skipped %s: no SciPy" % name)
            continue
        try:
            before = os.times()
            function()
            passed += 1
            if os.environ.get("VERBOSE"):
                print("%s: %.2f s of processors" % (name, sum(os.times()[:4]) - sum(before[:4])))
        except Skip as e:
            skipped += 1
            print("skipped %s: %s" % (name, e))
        except Exception:
            failed += 1
            print("FAILED %s" % name)
            print(re.sub("(?m)^", "    ", traceback.format_exc()[-1500:]))
    print("%d passed, %d failed, %d skipped" % (passed, failed, skipped))
    return failed > 0


if __name__ == "__main__":
    sys.exit(main())
