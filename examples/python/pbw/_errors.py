"""Failures of the library as exceptions that name the argument, the place and what is allowed."""
import numpy as np

from ._scipy import as_scipy

ARGUMENT, NOT_FINITE, TOO_LARGE, MEMORY = 3, 4, 5, 6          # of pbw_status
DEGENERATE = 1


class Error(RuntimeError):
    """A triangulation that does not exist, such as that of points on one line; scipy.spatial.QhullError, too."""

    def __reduce__(self):
        return Error, self.args


QhullError = Error                 # SciPy's name for it


def not_finite(name, array):
    """What is wrong with the first number of an array that is NaN or infinite; None if all are finite."""
    for place in np.argwhere(~np.isfinite(array))[:1]:
        return "%s[%s] is %s: it must be finite" % (name, ", ".join(map(str, place)), array[tuple(place)])
    return None


def _degenerate(points):
    distinct, dim = len(np.unique(points, axis=0)), points.shape[1]
    if distinct <= dim:
        what = "%d of %d points are distinct, and %dD needs at least %d" % (distinct, len(points), dim, dim + 1)
    else:
        what = "all %d points lie exactly %s" % (len(points), "on one line" if dim == 2 else "in one plane")
    return "no triangulation: " + what


def from_status(status, text, points, weights):
    """The exception for a status that is not PBW_OK."""
    if status == DEGENERATE:
        return as_scipy(Error, "QhullError")(_degenerate(points))
    if status == MEMORY:
        return MemoryError("%s, for %d points in %dD" % (text, *points.shape))
    if status == NOT_FINITE:
        return ValueError(not_finite("points", points) or not_finite("weights", weights))
    return (ValueError if status in (ARGUMENT, TOO_LARGE) else Error)(text)
