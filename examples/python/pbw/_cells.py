"""Cells: the functions power_cells and lloyd, the classes Cells and Voronoi."""
import operator
from functools import cached_property

import numpy as np

from . import _library
from ._arguments import check_options, checked_more, checked_points, checked_weights
from ._handle import Handle
from ._library import Mesh
from ._scipy import as_scipy, own

FACETS, SHAPES, MERGE = 1, 2, 4                   # of PBW_CELLS_*


class Cells:
    """Cells of points; made by power_cells.

    volumes                 (npoints,): in the plane areas; inf if unbounded, 0 if empty
    centroids               (npoints, ndim): of empty and unbounded cells the point itself
    first                   (npoints + 1,): the facets of cell i are first[i] to first[i+1] - 1
    neighbors               per facet: the point beyond; -2 - k: wall k of the box, where 2*axis is the low and
                            2*axis+1 the high one
    shifts                  per facet, if periodic: the neighbour is that point, from its site, + shift * size of the
                            box, of a lattice + shift @ lattice
    sites                   (npoints, ndim), if periodic: where the points were moved to
    areas                   per facet: its area, in the plane its length
    vertices                (nvertices, ndim)
    loop_first, loops       corners of facet j: vertices loops[loop_first[j]:loop_first[j+1]], counter-clockwise from
                            outside of the cell; -2 - k: at infinity, in the direction rays[k]
    rays                    (nrays, ndim)
    """

    __module__ = "pbw"

    def __init__(self, arrays):
        self.__dict__.update(arrays)

    def __repr__(self):
        return "<pbw.Cells: %d cells, %d facets>" % (len(self.volumes), len(self.neighbors))


def _checked_box(box, dim):
    if box is None:
        return None
    box = np.array(box, dtype=np.float64).reshape(-1)
    if box.shape != (2 * dim,) or not np.isfinite(box).all() or not (box[:dim] < box[dim:]).all():
        raise ValueError("box must be a low corner and a high corner above it, %d finite numbers, not %s"
                         % (2 * dim, box.tolist()))
    return box


def _checked_axes(periodic, box, dim):
    """Bit k: axis k."""
    if set(periodic) - set("xyz"[:dim]):
        raise ValueError("periodic must have letters of %r only, not %r" % ("xyz"[:dim], periodic))
    if periodic and box is None:
        raise ValueError("periodic=%r needs a box" % periodic)
    return sum(1 << "xyz".index(axis) for axis in set(periodic))


def _checked_lattice(lattice, box, dim):
    if lattice is None:
        return None
    if box is not None:
        raise ValueError("box and lattice exclude each other")
    lattice = np.array(lattice, dtype=np.float64)
    if lattice.shape != (dim, dim) or not np.isfinite(lattice).all():
        raise ValueError("lattice must be %d vectors of %d finite numbers, not %s" % (dim, dim, lattice.tolist()))
    return lattice


def _is_cuda(device, **others):
    """Whether the device is a GPU; others: arguments by name that need the CPU."""
    if device not in ("cpu", "cuda"):
        raise ValueError("device must be 'cpu' or 'cuda', not %r" % (device,))
    for name, value in others.items():
        if device == "cuda" and value is not None and not (isinstance(value, (bool, str)) and not value):
            raise ValueError("device='cuda' makes no cells with %s" % name)
    return device == "cuda"


def power_cells(points, weights=None, box=None, *, periodic="", lattice=None, merge=False, threads=0, device="cpu"):
    """The cells of the power diagram of points, without weights of the Voronoi diagram; see Cells.

    box        low corner and high corner: cells end there; None: those at the hull are unbounded.  In a box, one
               point, points on a line and points in a plane have cells, too
    periodic   the axes along which the box repeats, such as "xy"
    lattice    instead of a box: vectors, a row each, by which all repeats, at any angles, as of triclinic crystals
    merge      the true diagram: centres that coincide are one vertex, facets without area are left out
    device     "cuda": mesh and cells by an NVIDIA GPU, in a box or in the whole space; the same bytes, but vertices,
               loops and rays are None.  In a periodic box they are the same up to rounding if points are uneven.
               Raises Error if pbw was built without CUDA, there is no GPU, or points of a periodic box are too few
    """
    by_gpu = _is_cuda(device, lattice=lattice, merge=merge)
    points = checked_points(points)
    weights = None if weights is None else checked_weights(weights, len(points))
    check_options(False, None, threads)
    box = _checked_box(box, points.shape[1])
    axes = _checked_axes(periodic, box, points.shape[1])
    lattice = _checked_lattice(lattice, box, points.shape[1])
    if by_gpu:
        return Cells(_library.gpu_cells(points, weights, box, axes, True, threads))
    what = FACETS | SHAPES | (MERGE if merge else 0)
    if box is not None or lattice is not None:
        return Cells(_library.boxed_cells(points, weights, box, lattice, axes, what, threads))
    return Cells(Mesh(points, weights, threads, None).cells(what))


def lloyd(points, steps=10, box=None, *, periodic="", lattice=None, threads=0, device="cpu"):
    """The points after so many steps of Lloyd's relaxation: each moves to the centroid of its Voronoi cell.

    box        low corner and high corner, default that of the points' bounds; along axes of periodic it repeats
    lattice    instead of a box: vectors, a row each, by which all repeats, at any angles, as of triclinic crystals.
               Then points are moved by sums of vectors, as by power_cells
    device     "cuda": by an NVIDIA GPU, as by power_cells
    """
    by_gpu = _is_cuda(device, lattice=lattice)
    points = checked_points(points)
    check_options(False, None, threads)
    if operator.index(steps) < 0:
        raise ValueError("steps must not be negative: %d" % steps)
    dim = points.shape[1]
    lattice = _checked_lattice(lattice, box, dim)
    if box is None and lattice is None and len(points):
        box = [points.min(axis=0), points.max(axis=0)]
    box = _checked_box(box, dim)
    axes = _checked_axes(periodic, box, dim)
    for _ in range(steps):
        cells = (_library.gpu_cells(points, None, box, axes, False, threads) if by_gpu
                 else _library.boxed_cells(points, None, box, lattice, axes, 0, threads))
        points = cells["centroids"]
    return points


def _empty(cls):
    return cls.__new__(cls)


def _regions(loops, starts, points):
    """For each point the corners of its facets, each once, in the order in which they come."""
    loops, starts = loops.tolist(), starts.tolist()
    return [list(dict.fromkeys(loops[starts[i]:starts[i + 1]])) for i in points]


class Voronoi:
    """Voronoi diagram of points, an array of shape (npoints, 2) or (npoints, 3); see scipy.spatial.Voronoi.

    points, ndim, npoints, min_bound, max_bound
    vertices                (nvertices, ndim)
    ridge_points            (nridges, 2) int32: the points between which a ridge lies
    ridge_vertices          list of lists: its vertices in order, -1 at infinity
    ridge_dict              the same by pairs of points
    regions                 list of lists: the vertices of cells, -1 at infinity; in the plane in order.  The first is
                            empty
    point_region            (npoints,): the region of each point; of a duplicate, that of the point that it duplicates

    The diagram is the true one: four cocircular points have one vertex.  All but points are made at first use.
    """

    __module__ = "pbw"
    __class__ = property(lambda self: as_scipy(type(self), "Voronoi"))
    furthest_site = False

    def __init__(self, points, furthest_site=False, incremental=False, qhull_options=None, *, threads=0):
        check_options(furthest_site, qhull_options, threads)
        self._incremental, self._threads = bool(incremental), threads
        self._handle = None
        self._build(Mesh(checked_points(points), None, threads, None))

    def _build(self, mesh):
        points = mesh.points
        self._mesh = mesh
        self.points, self.ndim, self.npoints = points.copy(), points.shape[1], len(points)
        self.min_bound, self.max_bound = points.min(axis=0), points.max(axis=0)
        for name in _MADE:
            self.__dict__.pop(name, None)

    def __reduce__(self):
        """Without what can be made again.  (pickle's own way stops at a __class__ that is not the type.)"""
        state = {name: value for name, value in self.__dict__.items() if name not in _MADE}
        state["_handle"] = None
        return _empty, (own(type(self)),), state

    @cached_property
    def _cells(self):
        return self._mesh.cells(FACETS | SHAPES | MERGE)

    @cached_property
    def _numbered(self):
        """The vertices that are corners, and the corners of facets by their numbers among these, -1 at infinity."""
        loops = self._cells["loops"]
        number = np.full(len(self._cells["vertices"]), -1, np.int32)
        number[loops[loops >= 0]] = 0
        used = np.flatnonzero(number == 0)
        number[used] = np.arange(len(used))
        return used, np.where(loops >= 0, number[np.maximum(loops, 0)], -1)

    @cached_property
    def _ridges(self):
        """Of each two facets between two points the first."""
        site = np.repeat(np.arange(self.npoints), np.diff(self._cells["first"]))
        return site, np.flatnonzero(site < self._cells["neighbors"])

    @cached_property
    def _sites(self):
        return np.flatnonzero(self._mesh.canonical == np.arange(self.npoints))

    @cached_property
    def vertices(self):
        return self._cells["vertices"][self._numbered[0]]

    @cached_property
    def ridge_points(self):
        site, ridges = self._ridges
        return np.column_stack([site[ridges], self._cells["neighbors"][ridges]]).astype(np.int32)

    @cached_property
    def ridge_vertices(self):
        return _regions(self._numbered[1], self._cells["loop_first"], self._ridges[1].tolist())

    @cached_property
    def regions(self):
        starts = self._cells["loop_first"][self._cells["first"]]
        return [[]] + _regions(self._numbered[1], starts, self._sites.tolist())

    @cached_property
    def point_region(self):
        region = np.zeros(self.npoints, np.intp)
        region[self._sites] = np.arange(1, len(self._sites) + 1)
        return region[self._mesh.canonical]

    def __repr__(self):
        return "<pbw.%s: %d points in %dD, %d vertices, %d ridges>" % (
            type(self).__name__, self.npoints, self.ndim, len(self.vertices), len(self.ridge_points))

    @cached_property
    def ridge_dict(self):
        return {tuple(pair): ridge for pair, ridge in zip(self.ridge_points.tolist(), self.ridge_vertices)}

    def add_points(self, points, restart=False):
        """The diagram of the old points and these, for Voronoi(..., incremental=True).  The triangulation is changed
        where the points are; cells are rebuilt.  restart: the triangulation, too."""
        if not self._incremental:
            raise RuntimeError("points are added after Voronoi(..., incremental=True) and before close() only")
        points = checked_more(points, None, self._mesh)[0]
        handle, self._handle = self._handle, None
        if restart:
            self._build(Mesh(np.concatenate([self._mesh.points, points]), None, self._threads, None))
        else:
            handle = handle or Handle(self._mesh, None)
            handle.insert(points, None)
            handle.commit(changes=False)
            self._build(handle.mesh()[0])
            self._handle = handle

    def close(self):
        """No more points will be added."""
        self._incremental, self._handle = False, None


_MADE = [name for name, value in vars(Voronoi).items() if isinstance(value, cached_property)]
