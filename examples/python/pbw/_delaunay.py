"""The class Delaunay."""
import operator
from functools import cached_property

import numpy as np

from . import _geometry
from ._arguments import check_options, checked_more, checked_points, checked_weights
from ._errors import not_finite
from ._handle import Handle
from ._library import Mesh
from ._scipy import as_scipy, own

SCHEMES = "linear", "sibson", "laplace"           # in the order of pbw_scheme


def _empty(cls):
    return cls.__new__(cls)


class Delaunay:
    """Delaunay triangulation of points, an array of shape (npoints, 2) or (npoints, 3); see scipy.spatial.Delaunay.

    weights   one for each point: the regular triangulation (power diagram's dual) instead
    threads   0 is one for each core
    progress  called with a stage's name and the share of it that is done; an exception from it ends the build

    points, weights, ndim, npoints, nsimplex, min_bound, max_bound
    simplices               (nsimplex, ndim+1) int32
    neighbors               same shape: across from each corner, -1 outside
    vertex_to_simplex       (npoints,) int32: a simplex at each point, -1 if it is hidden
    vertex_neighbor_vertices   (indptr, indices): the neighbours of point k are indices[indptr[k]:indptr[k+1]]
    convex_hull             (nfacets, ndim) int32
    coplanar                (n, 3) int32: a duplicate, a simplex at it, the point that it duplicates
    hidden                  (n,) int32: points whose power cell is empty (with weights only)
    good                    (nsimplex,) int32: ones
    transform               (nsimplex, ndim+1, ndim): to barycentric coordinates; NaN for simplices that are so thin
                            that these would be noise (condition above 1/(1000 eps), as in SciPy)
    equations               (nsimplex, ndim+2): planes of the lifted simplices

    Arrays are made at first use, and are copies that one may write to.
    """

    __module__ = "pbw"
    __class__ = property(lambda self: as_scipy(type(self), "Delaunay"))
    furthest_site = False
    paraboloid_scale, paraboloid_shift = 1.0, 0.0

    def __init__(self, points, furthest_site=False, incremental=False, qhull_options=None, *, weights=None,
                 threads=0, progress=None):
        check_options(furthest_site, qhull_options, threads)
        points = checked_points(points)
        if weights is not None:
            weights = checked_weights(weights, len(points))
        self._incremental, self._threads, self._progress = bool(incremental), threads, progress
        self._mesh, self._handle = Mesh(points, weights, threads, progress), None

    def __repr__(self):
        kind = "points" if self._mesh.weights is None else "weighted points"
        rest = "".join(", %d %s" % (len(rows), what)
                       for rows, what in ((self.hidden, "hidden"), (self.coplanar, "duplicate")) if len(rows))
        return "<pbw.%s: %d %s in %dD%s, %d simplices>" % (type(self).__name__, self.npoints, kind, self.ndim, rest,
                                                          self.nsimplex)

    def __reduce__(self):
        """Without what can be made again.  (pickle's own way stops at a __class__ that is not the type.)"""
        state = {name: value for name, value in self.__dict__.items() if name not in _MADE}
        state["_progress"] = state["_handle"] = None
        return _empty, (own(type(self)),), state

    # Shape and arrays
    @property
    def npoints(self):
        return len(self._mesh.points)

    @property
    def ndim(self):
        return self._mesh.points.shape[1]

    @property
    def nsimplex(self):
        return len(self._mesh.simplices)

    @cached_property
    def points(self):
        return self._mesh.points.copy()

    @cached_property
    def weights(self):
        return None if self._mesh.weights is None else self._mesh.weights.copy()

    @cached_property
    def simplices(self):
        return self._mesh.simplices.copy()

    @cached_property
    def neighbors(self):
        return self._mesh.neighbors.copy()

    @cached_property
    def min_bound(self):
        return self._mesh.points[self._mesh.canonical >= 0].min(axis=0)

    @cached_property
    def max_bound(self):
        return self._mesh.points[self._mesh.canonical >= 0].max(axis=0)

    @cached_property
    def good(self):
        return np.ones(self.nsimplex, np.int32)

    @cached_property
    def vertex_to_simplex(self):
        canonical = self._mesh.canonical
        return np.where(canonical < 0, np.int32(-1), self._mesh.incident[canonical])

    @cached_property
    def coplanar(self):
        canonical, incident = self._mesh.canonical, self._mesh.incident
        duplicates = np.flatnonzero((canonical >= 0) & (canonical != np.arange(self.npoints))).astype(np.int32)
        return np.column_stack([duplicates, incident[canonical[duplicates]], canonical[duplicates]])

    @cached_property
    def hidden(self):
        own_place = (self._mesh.canonical == np.arange(self.npoints)) & (self._mesh.weights is not None)
        return np.flatnonzero(own_place & (self._mesh.incident < 0)).astype(np.int32)

    @cached_property
    def convex_hull(self):
        return _geometry.hull(self._mesh.simplices, self._mesh.neighbors)

    @cached_property
    def vertex_neighbor_vertices(self):
        return self._mesh.stars()

    @cached_property
    def transform(self):
        return _geometry.transforms(self._mesh.points, self._mesh.simplices)

    @cached_property
    def equations(self):
        return _geometry.planes(self._mesh.points, self._mesh.weights, self._mesh.simplices)

    # Parts
    def alpha_shape(self, alpha=np.inf, longest=np.inf):
        """Which simplices have a circumradius of at most alpha and no edge longer than longest: (nsimplex,) bool.

        tri.simplices[tri.alpha_shape(0.5)] is the alpha shape; both limits cut the ragged border of scattered points.
        With weights the radius is that of the sphere orthogonal to the balls of the corners.
        """
        for name, limit in ("alpha", alpha), ("longest", longest):
            if not limit > 0:
                raise ValueError("%s must be above 0, not %r" % (name, limit))
        points, weights, simplices = self._mesh.points, self._mesh.weights, self._mesh.simplices
        kept = np.ones(self.nsimplex, bool)
        if longest < np.inf:
            kept &= _geometry.longest_edges(points, simplices) <= longest
        if alpha < np.inf:
            kept &= _geometry.radii(points, weights, simplices) <= alpha
        return kept

    # Queries
    def lift_points(self, x):
        """The points with their height on the paraboloid as one more coordinate."""
        return _geometry.lift(x)

    def plane_distance(self, xi):
        """Distances to the planes of all lifted simplices: positive where a point is inside the circumsphere."""
        return self.lift_points(xi) @ self.equations[:, :-1].T + self.equations[:, -1]

    def find_simplex(self, xi, bruteforce=False, tol=None):
        """The simplex that has each point of xi, an array of shape (..., ndim), exactly; -1 outside of the hull.

        A point on a common face is in the lowest of its simplices.  bruteforce tries all, with the same answers.
        tol: points outside by no more than this barycentric coordinate are in the simplex where the hull was left.
        """
        shape, queries = self._checked_queries(xi)
        result = np.full(len(queries), -1, np.int32)
        finite = np.isfinite(queries).all(axis=1)
        queries = queries[finite]
        found = self._mesh.find_by_trying(queries) if bruteforce else self._mesh.find(queries)
        outside = np.flatnonzero(found < 0)
        if tol and len(outside):
            last = -1 - self._mesh.find(queries[outside])
            t = self.transform[last]
            b = np.einsum("ijk,ik->ij", t[:, :-1], queries[outside] - t[:, -1])
            near = (b >= -tol).all(axis=1) & (b.sum(axis=1) <= 1 + tol)
            found[outside] = np.where(near, last, -1)
        found[found < 0] = -1
        result[finite] = found
        return result.reshape(shape)

    def nearest(self, q, k=1):
        """Distances to the k nearest points of each of q, and these points, as scipy.spatial.cKDTree.query returns
        them: the nearest first, in exact order, equally near ones by index; for k=1 without the last axis.  Where
        there are fewer than k: inf and npoints.

        Of duplicates only the first point is found.  With weights, distances are power distances, |q - p|^2 - weight,
        and hidden points are not found.
        """
        shape, queries = self._checked_queries(q, finite=True)
        if operator.index(k) < 1:
            raise ValueError("k must be at least 1, not %d" % k)
        found, distances = self._mesh.nearest(queries, k)
        found = np.where(found < 0, self.npoints, found)
        shape += (k,) if k > 1 else ()
        return distances.reshape(shape), found.reshape(shape)

    def coordinates(self, xi, method="linear"):
        """Generalised barycentric coordinates: indptr, points, weights.  The weights of query i, from indptr[i] to
        indptr[i + 1], are not negative, sum to 1, and its points have the query as their mean by them.

        "linear": the corners of its simplex; "sibson": the shares that its Voronoi cell would take of theirs;
        "laplace": facets of that cell over distances.  Outside of the hull there are none.
        """
        if method not in SCHEMES:
            raise ValueError("method must be one of %s, not %r" % (", ".join(SCHEMES), method))
        return tuple(self._mesh.coordinates(self._checked_queries(xi, finite=True)[1], SCHEMES.index(method)))

    def _checked_queries(self, xi, finite=False):
        """Their shape without the last axis, and as rows."""
        xi = np.asarray(xi, dtype=np.float64)
        if xi.ndim == 0 or xi.shape[-1] != self.ndim:
            raise ValueError("wrong dimensionality in xi: the shape must be (..., %d), not %s"
                             % (self.ndim, xi.shape))
        if finite and not np.isfinite(xi).all():
            raise ValueError(not_finite("xi", xi))
        return xi.shape[:-1], np.ascontiguousarray(xi.reshape(-1, self.ndim))

    # Changes
    def add_points(self, points, restart=False, *, weights=None):
        """Inserts points into the triangulation of Delaunay(..., incremental=True); restart: rebuilds it instead.

        weights: one for each point, for triangulations with weights.  After an exception all is as before.
        """
        if not self._incremental:
            raise RuntimeError("points are added after Delaunay(..., incremental=True) and before close() only")
        points, weights = checked_more(points, weights, self._mesh)
        if restart:
            self._handle = None
            old = self._mesh
            self._mesh = Mesh(np.concatenate([old.points, points]),
                              None if weights is None else np.concatenate([old.weights, weights]), self._threads,
                              self._progress)
        else:
            self._mesh = self._changed(lambda handle: handle.insert(points, weights))
        self._forget()

    def close(self):
        """No more points will be added."""
        self._incremental, self._handle = False, None

    def _changed(self, queue):
        """The Mesh after a change that queue(handle) makes.  Where that fails, the handle, which may have changes in
        its queue, is given up: the next one is made of the mesh."""
        handle, self._handle = self._handle or Handle(self._mesh, self._progress), None
        queue(handle)
        handle.commit(changes=False)
        mesh, _ = handle.mesh()
        self._handle = handle
        return mesh

    def _forget(self):
        """Drops arrays that were made of an older mesh."""
        for name in _MADE:
            self.__dict__.pop(name, None)


_MADE = [name for name, value in vars(Delaunay).items() if isinstance(value, cached_property)]


def tsearch(tri, xi):
    """The simplices that have the points xi: tri.find_simplex(xi)."""
    return tri.find_simplex(xi)
