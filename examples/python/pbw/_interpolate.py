"""The function interpolate."""
import numpy as np

from ._delaunay import Delaunay


def interpolate(points, values, xi, method="linear", *, threads=0):
    """Values at xi, of shape (..., ndim), from values at points, of shape (npoints, ...); NaN outside of the hull.

    points   or a Delaunay, which is then not made again
    method   "linear": within simplices; "sibson": natural neighbours, smooth but at the points; "laplace": smooth
             within Delaunay circumspheres.  All give linear functions back

    Values at duplicates of a point are not used: the first counts.
    """
    tri = points if isinstance(points, Delaunay) else Delaunay(points, threads=threads)
    values = np.asarray(values)
    if values.ndim == 0 or len(values) != tri.npoints:
        raise ValueError("values must have the shape (%d, ...), one for each point, not %s" % (tri.npoints,
                                                                                              values.shape))
    if values.dtype.kind not in "biufc":
        raise ValueError("values must be numbers, not %s" % values.dtype)
    indptr, near, weights = tri.coordinates(xi, method)
    count = len(indptr) - 1
    query = np.repeat(np.arange(count), np.diff(indptr))
    flat = values.reshape(tri.npoints, -1)
    result = np.empty((count, flat.shape[1]), np.result_type(flat.dtype, np.float64))
    for k, column in enumerate(flat.T):
        terms = column[near] * weights
        parts = (terms.real, terms.imag) if np.iscomplexobj(terms) else (terms,)
        sums = [np.bincount(query, weights=part, minlength=count) for part in parts]
        result[:, k] = sums[0] + 1j * sums[1] if len(sums) > 1 else sums[0]
    result[indptr[1:] == indptr[:-1]] = np.nan
    return result.reshape(np.shape(xi)[:-1] + values.shape[1:])
