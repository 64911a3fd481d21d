"""Exact Delaunay and regular triangulations for NumPy, with the interface of scipy.spatial.Delaunay.

    import numpy, pbw
    points = numpy.random.rand(1000000, 3)
    tri = pbw.Delaunay(points)                       # or with weights=, which SciPy has not
    tri.simplices, tri.neighbors, tri.find_simplex([0.5, 0.5, 0.5])

`make` builds libpbw_python.so, which is looked for beside this file, in build/ of the source tree, and in the
environment variable PBW_LIBRARY.  Needs NumPy; no SciPy.

What is different from SciPy
  * All answers are exact.  Points are not dropped or merged for being nearly coplanar or nearly equal, simplices may
    be as thin as the points make them, and a lattice is tiled without overlaps.  `coplanar` has duplicates only.
  * Simplices are positively oriented in 3D as in 2D; facets of `convex_hull` are turned outward.
  * find_simplex gives the lowest of the simplices that a point on a common face belongs to.  tol is 0 unless given.
  * Cocircular and cospherical points: any triangulation is right; ours depends on the set of points alone.
  * 2D and 3D only, no furthest_site; qhull_options are accepted and have no effect.
  * add_points triangulates anew.  Arrays are read-only, and find_simplex works on them even if others are assigned.
  * paraboloid_scale is 1 and paraboloid_shift is 0: `equations` are those of the plain lift |p|^2 - weight.
"""
import ctypes
import os
import threading

import numpy as np

__all__ = ["Delaunay", "Error", "QhullError", "tsearch"]


class Error(RuntimeError):
    """A triangulation that does not exist, such as that of points on one line."""


QhullError = Error                 # SciPy's name for it

_PROGRESS = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_int, ctypes.c_double)
_STAGES = ("order", "build", "output", "check")


def _load():
    here = os.path.dirname(os.path.abspath(__file__))
    name = "libpbw_python.so"
    places = [os.environ.get("PBW_LIBRARY"), os.path.join(here, name),
              os.path.join(here, "..", "..", "build", name)]
    for place in places:
        if place and os.path.exists(place):
            library = ctypes.CDLL(place)
            break
    else:
        raise ImportError("%s is not there: run make, or set PBW_LIBRARY to its path" % name)
    doubles = np.ctypeslib.ndpointer(np.float64, flags="C_CONTIGUOUS")
    ints = np.ctypeslib.ndpointer(np.int32, flags="C_CONTIGUOUS")
    size, integer = ctypes.c_size_t, ctypes.POINTER(ctypes.c_int)
    library.pbw_python_build.restype = ctypes.c_void_p
    library.pbw_python_build.argtypes = [ctypes.c_int, doubles, ctypes.c_void_p, size, ctypes.c_int, integer,
                                         _PROGRESS, integer, ctypes.POINTER(size)]
    library.pbw_python_copy.restype = library.pbw_python_free.restype = None
    library.pbw_python_copy.argtypes = [ctypes.c_void_p, ints, ints, ints, ints]
    library.pbw_python_free.argtypes = [ctypes.c_void_p]
    library.pbw_python_find.argtypes = [ctypes.c_int, doubles, ints, ints, size, doubles, size, ctypes.c_int, ints]
    library.pbw_python_stars.restype = ctypes.c_int64
    library.pbw_python_stars.argtypes = [ctypes.c_int, ints, size, size, ints, ctypes.c_void_p]
    library.pbw_status_string.restype = ctypes.c_char_p
    return library


_library = _load()
_ARGUMENT, _NOT_FINITE, _TOO_LARGE, _MEMORY = 3, 4, 5, 6        # of pbw_status


def _triangulate(points, weights, threads, progress):
    """simplices, neighbors, incident, canonical."""
    count, dim = points.shape
    stop, status, simplex_count = ctypes.c_int(), ctypes.c_int(), ctypes.c_size_t()
    arrays, thrown = [], []

    def call(stage, done):
        try:
            progress(_STAGES[stage], done)
        except BaseException as e:
            thrown.append(e)
        return bool(thrown)

    def work():
        try:
            mesh = _library.pbw_python_build(dim, points, None if weights is None else weights.ctypes.data, count,
                                             threads, stop, _PROGRESS(call) if progress else _PROGRESS(), status,
                                             simplex_count)
            if mesh:
                try:
                    shape = (simplex_count.value, dim + 1)
                    made = [np.empty(s, np.int32) for s in (shape, shape, count, count)]
                    _library.pbw_python_copy(mesh, *made)
                    arrays.extend(made)
                finally:
                    _library.pbw_python_free(mesh)
        except BaseException as e:
            thrown.append(e)
        finally:
            finished.set()

    # Ctrl-C is seen by the main thread, and only between two steps of Python: it must not be the one that works.
    # The library stops within a tenth of a second; the wait has an end in case the thread was not started yet.
    finished = threading.Event()
    try:
        if count < 1000 and progress is None:
            work()                 # sooner done than a thread is started
        else:
            threading.Thread(target=work).start()
        while not finished.wait(0.1):
            pass
    except BaseException:
        stop.value = 1
        finished.wait(1)
        raise
    if thrown:
        raise thrown[0]
    if not arrays:
        text = _library.pbw_status_string(status).decode()
        if status.value == _MEMORY:
            raise MemoryError(text)
        raise (ValueError if status.value in (_ARGUMENT, _NOT_FINITE, _TOO_LARGE) else Error)(text)
    return arrays


def _z_order(points, low, high):
    """The order of the points along a Z-shaped curve, so that one is near the next."""
    bits = 32 // points.shape[1]
    with np.errstate(all="ignore"):
        span = np.where(high > low, high - low, 1)
        cell = (np.clip(np.nan_to_num((points - low) / span), 0, 1) * (2 ** bits - 1)).astype(np.uint64)
    key = np.zeros(len(points), np.uint64)
    for bit in range(bits):
        for k in range(points.shape[1]):
            key |= (cell[:, k] >> np.uint64(bit) & np.uint64(1)) << np.uint64(bit * points.shape[1] + k)
    return np.argsort(key, kind="stable")


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
    transform               (nsimplex, ndim+1, ndim): to barycentric coordinates; NaN for simplices that are so thin
                            that these would be noise (condition above 1/(1000 eps), as in SciPy)
    equations               (nsimplex, ndim+2): planes of the lifted simplices
    """

    furthest_site = False
    paraboloid_scale, paraboloid_shift = 1.0, 0.0

    def __init__(self, points, furthest_site=False, incremental=False, qhull_options=None, *, weights=None,
                 threads=0, progress=None):
        if furthest_site:
            raise ValueError("furthest_site is not supported")
        self._incremental, self._threads, self._progress = incremental, threads, progress
        self._build(points, weights)

    def _build(self, points, weights):
        if np.ma.isMaskedArray(points):
            raise ValueError("Input points cannot be a masked array")
        points = np.array(points, dtype=np.float64, order="C")
        if points.ndim != 2 or points.shape[1] not in (2, 3):
            raise ValueError("points must have the shape (npoints, 2) or (npoints, 3)")
        if len(points) >= 2 ** 31:
            raise ValueError("too many points for 32-bit indices")
        if weights is not None:
            weights = np.array(weights, dtype=np.float64, order="C")
            if weights.shape != points.shape[:1]:
                raise ValueError("weights must have one number for each point")
        arrays = _triangulate(points, weights, self._threads, self._progress)
        self._lazy = {}
        self.points, self.weights = points, weights
        self.npoints, self.ndim = points.shape
        self.min_bound, self.max_bound = points.min(axis=0), points.max(axis=0)
        self.simplices, self.neighbors, self.vertex_to_simplex, canonical = arrays
        self.nsimplex = len(self.simplices)
        own = canonical == np.arange(self.npoints)
        self.hidden = np.flatnonzero(own & (self.vertex_to_simplex < 0)).astype(np.int32)
        duplicates = np.flatnonzero(~own).astype(np.int32)
        self.vertex_to_simplex[duplicates] = self.vertex_to_simplex[canonical[duplicates]]
        self.coplanar = np.column_stack([duplicates, self.vertex_to_simplex[duplicates], canonical[duplicates]])
        self._arrays = points, self.simplices, self.neighbors          # for the library, whatever users assign
        for a in self._arrays:
            a.flags.writeable = False

    def _once(self, name, make):
        if name not in self._lazy:
            self._lazy[name] = make()
        return self._lazy[name]

    @property
    def convex_hull(self):
        def make():
            corners = {2: [[1, 2], [2, 0], [0, 1]], 3: [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]]}[self.ndim]
            simplex, facet = np.nonzero(self.neighbors < 0)
            return self.simplices[simplex[:, None], np.array(corners)[facet]]
        return self._once("convex_hull", make)

    @property
    def vertex_neighbor_vertices(self):
        def make():
            indptr = np.empty(self.npoints + 1, np.int32)
            simplices = self._arrays[1]
            arguments = self.ndim, simplices, len(simplices), self.npoints, indptr
            count = _library.pbw_python_stars(*arguments, None)
            if count < 0:
                raise MemoryError
            indices = np.empty(count, np.int32)
            if _library.pbw_python_stars(*arguments, indices.ctypes.data) < 0:
                raise MemoryError
            return indptr, indices
        return self._once("vertex_neighbor_vertices", make)

    def _frames(self):
        """For each simplex its last corner, the edges to it from the others, and their inverse matrix."""
        corner = self.points[self.simplices]
        edge = corner[:, :-1] - corner[:, -1:]
        if self.ndim == 2:
            turned = edge[:, ::-1, ::-1] * [1, -1]         # (v1, -v0), (u1, -u0)
            inverse = turned * np.array([1, -1])[:, None]
        else:
            inverse = np.stack([np.cross(edge[:, i - 2], edge[:, i - 1]) for i in range(3)], axis=1)
        with np.errstate(all="ignore"):
            inverse /= np.einsum("ik,ik->i", edge[:, 0], inverse[:, 0])[:, None, None]
        return corner[:, -1], edge, inverse

    @property
    def transform(self):
        def make():
            last, edge, inverse = self._frames()
            with np.errstate(all="ignore"):
                condition = np.abs(edge).sum(axis=2).max(axis=1) * np.abs(inverse).sum(axis=1).max(axis=1)
                inverse[~(condition * 1000 * np.finfo(float).eps <= 1)] = np.nan
            return np.concatenate([inverse, last[:, None]], axis=1)
        return self._once("transform", make)

    @property
    def equations(self):
        def make():
            last, edge, inverse = self._frames()
            lift = np.einsum("ik,ik->i", self.points, self.points)
            lift = (lift if self.weights is None else lift - self.weights)[self.simplices]
            slope = np.einsum("ij,ijk->ik", lift[:, :-1] - lift[:, -1:], inverse)
            offset = lift[:, -1] - np.einsum("ik,ik->i", slope, last)
            equations = np.column_stack([slope, -np.ones(self.nsimplex), offset])
            return equations / np.sqrt(1 + np.einsum("ik,ik->i", slope, slope))[:, None]
        return self._once("equations", make)

    def lift_points(self, x):
        """The points with their height on the paraboloid as one more coordinate."""
        x = np.asarray(x, dtype=np.float64)
        return np.concatenate([x, np.sum(x * x, axis=-1, keepdims=True)], axis=-1)

    def plane_distance(self, xi):
        """Distances to the planes of all lifted simplices: positive where a point is inside the circumsphere."""
        return self.lift_points(xi) @ self.equations[:, :-1].T + self.equations[:, -1]

    def _find(self, queries, every):
        found = np.empty(len(queries), np.int32)
        if _library.pbw_python_find(self.ndim, *self._arrays, len(self._arrays[1]), queries, len(queries), every,
                                    found):
            raise MemoryError
        return found

    def find_simplex(self, xi, bruteforce=False, tol=None):
        """The simplex that has each point of xi, an array of shape (..., ndim), exactly; -1 outside of the hull.

        A point on a common face is in the lowest of its simplices.  bruteforce tries all, with the same answers.
        tol: points outside by no more than this barycentric coordinate are in the simplex where the hull was left.
        """
        xi = np.asarray(xi, dtype=np.float64)
        if xi.ndim == 0 or xi.shape[-1] != self.ndim:
            raise ValueError("wrong dimensionality in xi")
        queries = np.ascontiguousarray(xi.reshape(-1, self.ndim))
        order = slice(None)
        if len(queries) > 100 and not bruteforce:
            order = _z_order(queries, self.min_bound, self.max_bound)
            queries = queries[order]
        found = self._find(queries, bruteforce)
        outside = np.flatnonzero(found < 0)
        if tol and len(outside):
            last = -1 - self._find(queries[outside], False)
            t = self.transform[last]
            b = np.einsum("ijk,ik->ij", t[:, :-1], queries[outside] - t[:, -1])
            near = (b >= -tol).all(axis=1) & (b.sum(axis=1) <= 1 + tol)
            found[outside] = np.where(near, last, -1)
        found[found < 0] = -1
        result = np.empty_like(found)
        result[order] = found
        return result.reshape(xi.shape[:-1])

    def add_points(self, points, restart=False):
        """The triangulation of the old points and these, made anew; for Delaunay(..., incremental=True)."""
        if not self._incremental:
            raise RuntimeError("incremental mode not enabled or already closed")
        if self.weights is not None:
            raise ValueError("points are added to triangulations without weights only")
        self._build(np.concatenate([self.points, points]), None)

    def close(self):
        """No more points will be added."""
        self._incremental = False


def tsearch(tri, xi):
    """The simplices that have the points xi: tri.find_simplex(xi)."""
    return tri.find_simplex(xi)
