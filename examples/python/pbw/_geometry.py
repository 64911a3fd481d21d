"""Derived arrays of a triangulation, in ordinary floating-point arithmetic: nothing here decides topology."""
import numpy as np


def hull(simplices, neighbors):
    """The facets without a neighbour, turned outward."""
    corners = {3: [[1, 2], [2, 0], [0, 1]], 4: [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]]}[simplices.shape[1]]
    simplex, facet = np.nonzero(neighbors < 0)
    return simplices[simplex[:, None], np.array(corners)[facet]]


def _frames(points, simplices):
    """For each simplex its last corner, the edges to it from the others, and their inverse matrix."""
    corner = points[simplices]
    edge = corner[:, :-1] - corner[:, -1:]
    if points.shape[1] == 2:
        turned = edge[:, ::-1, ::-1] * [1, -1]         # (v1, -v0), (u1, -u0)
        inverse = turned * np.array([1, -1])[:, None]
    else:
        inverse = np.stack([np.cross(edge[:, i - 2], edge[:, i - 1]) for i in range(3)], axis=1)
    with np.errstate(all="ignore"):
        inverse /= np.einsum("ik,ik->i", edge[:, 0], inverse[:, 0])[:, None, None]
    return corner[:, -1], edge, inverse


def transforms(points, simplices):
    """To barycentric coordinates; NaN where these would be noise: condition above 1/(1000 eps), as in SciPy."""
    last, edge, inverse = _frames(points, simplices)
    with np.errstate(all="ignore"):
        condition = np.abs(edge).sum(axis=2).max(axis=1) * np.abs(inverse).sum(axis=1).max(axis=1)
        inverse[~(condition * 1000 * np.finfo(float).eps <= 1)] = np.nan
    return np.concatenate([inverse, last[:, None]], axis=1)


def planes(points, weights, simplices):
    """Normal and offset of each lifted simplex, turned down."""
    last, edge, inverse = _frames(points, simplices)
    height = np.einsum("ik,ik->i", points, points)
    height = (height if weights is None else height - weights)[simplices]
    slope = np.einsum("ij,ijk->ik", height[:, :-1] - height[:, -1:], inverse)
    offset = height[:, -1] - np.einsum("ik,ik->i", slope, last)
    equations = np.column_stack([slope, -np.ones(len(simplices)), offset])
    return equations / np.sqrt(1 + np.einsum("ik,ik->i", slope, slope))[:, None]


def longest_edges(points, simplices):
    """The length of the longest edge of each simplex; scaled, so that no square is out of range."""
    a, b = np.triu_indices(simplices.shape[1], 1)
    longest = np.zeros(len(simplices))
    for i, k in zip(a, b):
        edge = np.abs(points[simplices[:, i]] - points[simplices[:, k]])
        scale = edge.max(axis=1)
        with np.errstate(all="ignore"):
            longest = np.fmax(longest, scale * np.sqrt(((edge / scale[:, None]) ** 2).sum(axis=1)))
    return longest


def radii(points, weights, simplices):
    """The radius of the sphere that is orthogonal to the balls of the corners of each simplex, the circumscribed one
    without weights; infinite where the simplex is flat.  Its centre c, seen from the first corner, is where
    e . c = (|e|^2 + w0 - w) / 2 for each edge e from there to a corner of weight w: Cramer's rule, in the plane with
    a third edge across.  Edges are scaled to 1, so that no square is out of range."""
    count, dim = len(simplices), points.shape[1]
    edge = np.zeros((count, 3, 3))
    edge[:, :dim, :dim] = points[simplices[:, 1:]] - points[simplices[:, :1]]
    scale = np.abs(edge).max(axis=(1, 2))
    edge[:, :dim] /= scale[:, None, None]
    edge[:, dim:, 2] = 1
    height = np.einsum("ijk,ijk->ij", edge, edge) / 2
    height[:, dim:] = 0
    power = np.zeros(count)
    if weights is not None:
        scaled = weights[simplices] / scale[:, None] / scale[:, None]
        power -= scaled[:, 0]
        height[:, :dim] += (scaled[:, :1] - scaled[:, 1:]) / 2
    across = np.stack([np.cross(edge[:, i - 2], edge[:, i - 1]) for i in range(3)], axis=1)
    with np.errstate(all="ignore"):
        centre = np.einsum("ij,ijk->ik", height, across) / np.einsum("ik,ik->i", edge[:, 0], across[:, 0])[:, None]
        power += np.einsum("ik,ik->i", centre, centre)
        return np.where(power < np.inf, scale * np.sqrt(np.maximum(power, 0)), np.inf)


def lift(x):
    """The points with their height on the paraboloid as one more coordinate."""
    x = np.asarray(x, dtype=np.float64)
    return np.concatenate([x, np.sum(x * x, axis=-1, keepdims=True)], axis=-1)
