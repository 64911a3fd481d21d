"""The function interpolate."""
import numpy as np

from ._delaunay import Delaunay

MOST = 1e-6                        # of the way to the middle that a query is moved


class _Border:
    """Moves queries at the border of the hull a little inward.

    A point that was computed to be on an edge of the hull lies beside it by rounding; points that were computed to be
    on a line, or in a plane, are corners of simplices as thin as that, which join ends of the border.  Both are of no
    concern to a query that is moved by tol times the size of the coordinates.
    """

    def __init__(self, tri, tol):
        self.tri, mesh = tri, tri._mesh
        points = mesh.points
        facets = points[tri.convex_hull]
        start = facets[:, 0].mean(axis=0)
        edges = facets - start                       # the centroid of the hull is far from all of its facets
        volumes = np.abs(np.linalg.det(edges))
        self.middle = start + (volumes[:, None] * edges.sum(axis=1)).sum(axis=0) / (volumes.sum() * (tri.ndim + 1))
        self.reach = tol * np.abs(points[tri.convex_hull]).max()

    def thin(self, simplices):
        """Whether simplices are thinner than the tolerance: by volume over the largest facet."""
        mesh = self.tri._mesh
        corners = mesh.points[mesh.simplices[simplices]]
        volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1]))         # times ndim!
        areas = [np.linalg.norm(_normals(np.delete(corners, k, axis=1)), axis=1) for k in range(self.tri.ndim + 1)]
        return volumes <= self.reach * np.max(areas, axis=0)

    def moved(self, queries, simplices):
        """The queries, moved towards the middle: by the tolerance away from the facets of their simplices that are on
        the hull, by as much where there are none."""
        mesh, way = self.tri._mesh, self.middle - queries
        length = np.linalg.norm(way, axis=1)
        for k in range(self.tri.ndim + 1):
            border = np.flatnonzero(mesh.neighbors[simplices, k] < 0)
            corners = mesh.points[np.delete(mesh.simplices[simplices[border]], k, axis=1)]
            normals = _normals(corners)
            areas = np.linalg.norm(normals, axis=1)
            heights = np.abs(np.einsum("ij,ij->i", normals, self.middle - corners[:, 0]))
            length[border] = np.minimum(length[border], heights / np.where(areas > 0, areas, 1))
        share = self.reach / np.maximum(length, self.reach / MOST)
        return queries + share[:, None] * way


def _normals(facets):
    """Of triangles in space, or edges in the plane: twice their area long, or their length."""
    edges = facets[:, 1:] - facets[:, :1]
    if facets.shape[2] == 3:
        return np.cross(edges[:, 0], edges[:, 1])
    return np.column_stack([-edges[:, 0, 1], edges[:, 0, 0]])


def _moved_inward(tri, queries, tol):
    """The queries; those outside, or in thin simplices, moved inward where that is inside."""
    found, border = tri._mesh.find(queries), _Border(tri, tol)
    moved = border.moved(queries, np.where(found < 0, -1 - found, found))
    again = tri._mesh.find(moved)
    takes = (found < 0) & (again >= 0)
    other = np.flatnonzero((found >= 0) & (again >= 0) & (found != again))
    takes[other] = border.thin(found[other])
    return np.where(takes[:, None], moved, queries)


def interpolate(points, values, xi, method="linear", *, outside="nan", tol=None, threads=0):
    """Values at xi, of shape (..., ndim), from values at points, of shape (npoints, ...).

    points   or a Delaunay, which is then not made again
    method   "linear": within simplices; "sibson": natural neighbours, smooth but at the points; "laplace": smooth
             within Delaunay circumspheres.  All give linear functions back
    outside  of the hull: "nan", or "nearest": the value of the nearest point.  A query that is not finite has NaN
    tol      what is outside by that much of the largest coordinate is inside still, and simplices that are thinner do
             not count; default 100 times the spacing of doubles at 1.  0: the hull and the simplices as they are

    Values at duplicates of a point are not used: the first counts.
    """
    tri = points if isinstance(points, Delaunay) else Delaunay(points, threads=threads)
    values = np.asarray(values)
    if values.ndim == 0 or len(values) != tri.npoints:
        raise ValueError("values must have the shape (%d, ...), one for each point, not %s" % (tri.npoints,
                                                                                              values.shape))
    if values.dtype.kind not in "biufc":
        raise ValueError("values must be numbers, not %s" % values.dtype)
    if outside not in ("nan", "nearest"):
        raise ValueError("outside must be nan or nearest, not %r" % (outside,))
    tol = 100 * np.finfo(float).eps if tol is None else float(tol)
    if not 0 <= tol < 1:
        raise ValueError("tol must be from 0 to below 1, not %r" % tol)
    shape, queries = tri._checked_queries(xi)
    finite = np.flatnonzero(np.isfinite(queries).all(axis=1))
    places = queries[finite]
    if tol and len(finite) and tri.nsimplex:
        places = _moved_inward(tri, places, tol)
    indptr, near, weights = tri.coordinates(places, method)
    flat = values.reshape(tri.npoints, -1)
    result = np.full((len(queries), flat.shape[1]), np.nan, np.result_type(flat.dtype, np.float64))
    query = np.repeat(finite, np.diff(indptr))
    for k, column in enumerate(flat.T):
        terms = column[near] * weights
        parts = (terms.real, terms.imag) if np.iscomplexobj(terms) else (terms,)
        sums = [np.bincount(query, weights=part, minlength=len(queries)) for part in parts]
        result[:, k] = sums[0] + 1j * sums[1] if len(sums) > 1 else sums[0]
    beyond = finite[indptr[1:] == indptr[:-1]]
    result[np.setdiff1d(np.arange(len(queries)), finite)] = result[beyond] = np.nan
    if outside == "nearest" and len(beyond):
        result[beyond] = flat[tri.nearest(queries[beyond])[1]]
    return result.reshape(shape + values.shape[1:])
