"""Arguments of the caller, checked and converted."""
import operator

import numpy as np


def checked_points(points):
    if np.ma.isMaskedArray(points):
        raise ValueError("points cannot be a masked array")
    points = np.array(points, dtype=np.float64, order="C")
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise ValueError("points must have the shape (npoints, 2) or (npoints, 3), not %s" % (points.shape,))
    if len(points) >= 2 ** 31:
        raise ValueError("%d points are too many for 32-bit indices" % len(points))
    return points


def checked_weights(weights, count):
    weights = np.array(weights, dtype=np.float64, order="C")
    if weights.shape != (count,):
        raise ValueError("weights must have the shape (%d,), one for each point, not %s" % (count, weights.shape))
    return weights


def check_options(furthest_site, qhull_options, threads):
    if isinstance(qhull_options, bytes):
        qhull_options = qhull_options.decode("ascii", "replace")
    for option in (qhull_options or "").split():
        if option[:2] in ("Qu", "QG", "QV"):
            raise ValueError("the Qhull option %s is not supported" % option)
    if furthest_site:
        raise ValueError("furthest_site is not supported")
    if not 0 <= operator.index(threads) <= 256:
        raise ValueError("threads must be 0 (one for each core) to 256, not %d" % threads)


def checked_more(points, weights, mesh):
    """Points to add to a mesh, with weights if it has some."""
    points = checked_points(points)
    if points.shape[1] != mesh.points.shape[1]:
        raise ValueError("points to add must have the shape (n, %d), not %s" % (mesh.points.shape[1], points.shape))
    if (weights is None) != (mesh.weights is None):
        raise ValueError("points are added with weights where the others have weights, and only there")
    return points, None if weights is None else checked_weights(weights, len(points))
