"""The class Live."""
import collections

import numpy as np

from ._arguments import check_options, checked_points, checked_weights
from ._delaunay import Delaunay, _empty, _MADE
from ._handle import Handle
from ._library import Mesh

Changes = collections.namedtuple("Changes", "way deleted made points")
Changes.__doc__ = """What a commit changed: the way taken ("nothing", "flips", "batch", "rebuild"), the corners of
simplices that went and of those that came, and the points with another star than before."""


def checked_ids(ids):
    ids = np.atleast_1d(np.asarray(ids))
    if ids.size == 0:
        ids = ids.astype(np.int32)
    if ids.ndim != 1 or ids.dtype.kind not in "iu" or (ids.size and not 0 <= ids.min() <= ids.max() < 2 ** 31):
        raise ValueError("ids must be numbers of points, an array of whole numbers from 0 on")
    return np.ascontiguousarray(ids, np.int32)


class Live(Delaunay):
    """A triangulation of points that are inserted, removed and moved; weights: the regular triangulation.

        live = pbw.Live(points)
        ids = live.insert(more)
        live.remove(ids[:10])
        live.move([0, 1], [[0.1, 0.2], [0.3, 0.4]])
        changes = live.commit()
        live.simplices, live.neighbors, live.find_simplex([0.5, 0.5])

    Changes are queued until commit, which carries out all or, after an exception, none of them, and leaves them
    queued.  What is here otherwise, attributes and queries, is as of Delaunay, of the triangulation after the last
    commit.  Points have numbers that stay theirs: 0 to npoints - 1 at first, then those that insert returns.  That of
    a removed point is given again, to an insertion after the commit; until then it is in no simplex, its row of
    points is 0, and vertex_to_simplex says -1.  `numbers` are those that are in use.
    The points may be none, or may span no simplex: then there are none.
    Threads may share it: their calls wait for each other, and attributes are of one commit.  A progress callback must
    not use the triangulation that calls it.
    """

    def __init__(self, points, weights=None, *, threads=0, progress=None):
        check_options(False, None, threads)
        points = checked_points(points)
        weights = None if weights is None else checked_weights(weights, len(points))
        self._incremental, self._threads, self._progress = False, threads, progress
        self._handle, self._now = Handle(Mesh.empty(points.shape[1], weights is not None, threads), progress), None
        self._handle.insert(points, weights)
        self.commit(changes=False)

    def __reduce__(self):
        raise TypeError("a pbw.Live is not copied nor pickled; its points and weights are")

    def _current(self):
        """The triangulation after the last commit as a Delaunay, which does not change."""
        now = self._now
        if now is None or now._version != self._handle.version:
            now = _empty(Delaunay)
            now._mesh, now._version = self._handle.mesh()
            self._now = now
        return now

    @property
    def _mesh(self):
        return self._current()._mesh

    @property
    def ndim(self):
        return self._handle.dim

    @property
    def numbers(self):
        """The numbers of points that are in use, ascending."""
        return np.flatnonzero(self._mesh.canonical >= 0).astype(np.int32)

    def insert(self, points, weights=None):
        """Queues points to be inserted; returns their numbers.  weights: where there are some, else all are 0."""
        points = checked_points(points)
        if points.shape[1] != self.ndim:
            raise ValueError("points to insert must have the shape (n, %d), not %s" % (self.ndim, points.shape))
        if weights is not None and not self._handle.weighted:
            raise ValueError("points are inserted with weights where the first ones had weights, and only there")
        weights = None if weights is None else checked_weights(weights, len(points))
        return self._handle.insert(points, weights)

    def remove(self, ids):
        """Queues points to be removed, by their numbers."""
        self._handle.remove(checked_ids(ids))

    def move(self, ids, points):
        """Queues points to be moved to other places; of a number given twice the last counts.  ids None: all numbers,
        and the rows of numbers that are not in use are not read."""
        points = checked_points(points)
        ids = None if ids is None else checked_ids(ids)
        if points.shape[1] != self.ndim or (ids is not None and len(ids) != len(points)):
            raise ValueError("points must have the shape (%s, %d), not %s"
                             % ("n" if ids is None else len(ids), self.ndim, points.shape))
        self._handle.move(ids, points)

    def commit(self, changes=True):
        """Carries out what is queued; returns Changes, or None without changes, which is quicker."""
        made = self._handle.commit(changes)
        return Changes(*made) if changes else None

    def add_points(self, points, restart=False, *, weights=None):
        """As of Delaunay: insert, and commit."""
        self.insert(points, weights)
        self.commit(changes=False)

    def close(self):
        """As of Delaunay; there is nothing to do."""


def _of_now(name):
    return property(lambda self: getattr(self._current(), name),
                    lambda self, value: setattr(self._current(), name, value), doc=getattr(Delaunay, name).__doc__)


for _name in _MADE:
    setattr(Live, _name, _of_now(_name))
