"""The shared library of pbw_python.c, and a triangulation as it makes it.

In: arrays that were checked.  Out: a Mesh of read-only arrays, which only the library reads; users get copies.
"""
import ctypes
import os
import threading

import numpy as np

from . import _errors

_PROGRESS = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_int, ctypes.c_double)
_STAGES = ("order", "build", "output", "check", "work")


def _pointers(names):
    return [(name, ctypes.c_void_p) for name in names.split()]


class _Arrays(ctypes.Structure):
    """struct arrays of pbw_python.h."""
    _fields_ = [("dim", ctypes.c_int), ("threads", ctypes.c_int), ("point_count", ctypes.c_size_t),
                ("simplex_count", ctypes.c_size_t),
                *_pointers("points weights simplices neighbors incident canonical"),
                ("stop", ctypes.POINTER(ctypes.c_int))]


class _Lists(ctypes.Structure):
    """pbw_lists."""
    _fields_ = [("count", ctypes.c_size_t), *_pointers("first item value memory")]


class _Cells(ctypes.Structure):
    """pbw_cells."""
    _fields_ = [("dim", ctypes.c_int), *((name, ctypes.c_size_t) for name in ("cell_count", "facet_count",
                                                                            "vertex_count", "ray_count")),
                *_pointers("volumes centroids first neighbors shifts sites areas vertices loop_first loops rays "
                            "memory")]


class _PlaneInput(ctypes.Structure):
    """pbw_plane_input."""
    _fields_ = [(name, kind) for names in ("points point_count", "segments segment_count", "segment_ids",
                                           "segment_lefts", "holes hole_count", "regions region_count", "sizes")
                for name, kind in zip(names.split(), (ctypes.c_void_p, ctypes.c_size_t))]


class _PlaneRequest(ctypes.Structure):
    """struct plane_request of pbw_python.h."""
    _fields_ = [("rule", ctypes.c_int), ("threads", ctypes.c_int), ("flags", ctypes.c_uint),
                ("angle", ctypes.c_double), ("area", ctypes.c_double), ("steiner_limit", ctypes.c_size_t),
                ("most", ctypes.c_double), ("way", ctypes.c_int), ("rounds", ctypes.c_int)]


class _Watch(ctypes.Structure):
    """struct watch of pbw_python.h."""
    _fields_ = [("stop", ctypes.POINTER(ctypes.c_int)), ("progress", _PROGRESS)]


class _Changes(ctypes.Structure):
    """pbw_changes."""
    _fields_ = [("way", ctypes.c_int), *((name, ctypes.c_size_t) for name in ("deleted_count", "made_count",
                                                                            "point_count")),
                *_pointers("deleted made points memory")]


class _Plane(ctypes.Structure):
    """pbw_plane."""
    _fields_ = [("point_count", ctypes.c_size_t), ("input_count", ctypes.c_size_t),
                ("triangle_count", ctypes.c_size_t), *_pointers("points triangles neighbors constraints regions"),
                ("edge_count", ctypes.c_size_t), *_pointers("edges edge_first edge_segments"),
                ("region_count", ctypes.c_size_t), *_pointers("region_windings region_seeds"),
                ("crossing_count", ctypes.c_size_t), ("crossings", ctypes.c_void_p),
                ("report", ctypes.c_size_t * 5), ("limited", ctypes.c_int), ("rounds", ctypes.c_int),
                ("estimate", ctypes.c_double),
                ("what", ctypes.c_char * 160), ("bytes", ctypes.c_size_t), ("memory", ctypes.c_void_p)]


def _fit(library, first, *structures):
    """Refuses a library whose structures, from number first of pbw_python_size on, have other sizes than these."""
    for number, structure in enumerate(structures, first):
        if library.pbw_python_size(number) != ctypes.sizeof(structure):
            raise ImportError("libpbw_python.so is of another version: its %s has another size"
                              % structure.__doc__.rstrip("."))


def _load():
    here = os.path.dirname(os.path.abspath(__file__))
    name = "libpbw_python.so"
    places = [os.environ.get("PBW_LIBRARY"), os.path.join(here, name),
              os.path.join(here, "..", "..", "..", "build", name)]
    for place in places:
        if place and os.path.exists(place):
            break
    else:
        raise ImportError("%s is not there: run make or pip install, or set PBW_LIBRARY to its path" % name)
    try:
        library = ctypes.CDLL(place)
        _declare(library)
    except (AttributeError, OSError) as e:
        raise ImportError("%s does not fit this version of pbw: %s" % (place, e)) from e
    return library


def _declare(library):
    library.pbw_python_size.restype = ctypes.c_size_t
    _fit(library, 0, _Arrays, _Lists, _Cells, _PlaneInput, _PlaneRequest, _Watch, _Changes, _Plane)
    doubles = np.ctypeslib.ndpointer(np.float64, flags="C_CONTIGUOUS")
    ints = np.ctypeslib.ndpointer(np.int32, flags="C_CONTIGUOUS")
    size, integer, arrays = ctypes.c_size_t, ctypes.POINTER(ctypes.c_int), ctypes.POINTER(_Arrays)
    library.pbw_python_build.restype = ctypes.c_void_p
    library.pbw_python_build.argtypes = [ctypes.c_int, doubles, ctypes.c_void_p, size, ctypes.c_int, integer,
                                         _PROGRESS, integer, ctypes.POINTER(size)]
    library.pbw_python_copy.restype = library.pbw_python_free.restype = None
    library.pbw_python_copy.argtypes = [ctypes.c_void_p, ints, ints, ints, ints]
    library.pbw_python_free.argtypes = [ctypes.c_void_p]
    _declare_live(library)
    library.pbw_python_try_all.restype = None
    library.pbw_python_try_all.argtypes = [arrays, doubles, size, ints]
    library.pbw_python_locate.argtypes = [arrays, doubles, size, ints, ints]
    library.pbw_python_nearest.argtypes = [arrays, ctypes.c_void_p, ctypes.c_void_p, doubles, size, size, ints,
                                           doubles]
    library.pbw_python_coordinates.argtypes = [arrays, doubles, size, ctypes.c_int, ctypes.POINTER(_Lists)]
    library.pbw_python_cells.argtypes = [arrays, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_uint, ctypes.c_uint,
                                         ctypes.POINTER(_Cells)]
    library.pbw_python_gpu_cells.argtypes = [arrays, ctypes.c_void_p, ctypes.c_uint, ctypes.c_int,
                                             ctypes.POINTER(_Cells), ctypes.c_char_p, size]
    library.pbw_lists_free.restype = library.pbw_cells_free.restype = library.pbw_python_gpu_free.restype = None
    library.pbw_python_gpu_free.argtypes = [ctypes.POINTER(_Cells)]
    library.pbw_lists_free.argtypes = [ctypes.POINTER(_Lists)]
    library.pbw_cells_free.argtypes = [ctypes.POINTER(_Cells)]
    library.pbw_python_stars.argtypes = [arrays, ctypes.POINTER(_Lists)]
    library.pbw_python_check.argtypes = [arrays, integer]
    library.pbw_python_plane.argtypes = [ctypes.POINTER(_PlaneInput), ctypes.c_void_p, ctypes.c_void_p, size,
                                         ctypes.POINTER(_PlaneRequest), integer, ctypes.POINTER(_Plane)]
    library.pbw_plane_transfer.argtypes = [ctypes.POINTER(_Plane), ctypes.POINTER(_Plane), doubles, size, doubles,
                                           ctypes.c_void_p]
    library.pbw_plane_free.restype = None
    library.pbw_plane_free.argtypes = [ctypes.POINTER(_Plane)]
    library.pbw_status_string.restype = ctypes.c_char_p
    library.pbw_version.restype = ctypes.c_int


def _declare_live(library):
    doubles = np.ctypeslib.ndpointer(np.float64, flags="C_CONTIGUOUS")
    ints = np.ctypeslib.ndpointer(np.int32, flags="C_CONTIGUOUS")
    size, live = ctypes.c_size_t, ctypes.c_void_p
    library.pbw_python_live.argtypes = [ctypes.POINTER(_Arrays), ctypes.POINTER(_Watch), ctypes.POINTER(live)]
    library.pbw_python_live_view.restype = ctypes.c_void_p
    library.pbw_python_live_view.argtypes = [live, ctypes.POINTER(ctypes.c_int), ctypes.POINTER(size),
                                             ctypes.POINTER(size)]
    library.pbw_python_copy_points.restype = None
    library.pbw_python_copy_points.argtypes = [ctypes.c_void_p, doubles, doubles]
    library.pbw_live_insert.argtypes = [live, doubles, ctypes.c_void_p, size, ints]
    library.pbw_live_remove.argtypes = [live, ints, size]
    library.pbw_live_move.argtypes = [live, ctypes.c_void_p, doubles, size]
    library.pbw_live_commit.argtypes = [live, ctypes.POINTER(_Changes)]
    library.pbw_changes_free.restype = library.pbw_live_free.restype = None
    library.pbw_changes_free.argtypes = [ctypes.POINTER(_Changes)]
    library.pbw_live_free.argtypes = [live]


_library = _load()
_number = _library.pbw_version()
version = "%d.%d.%d" % (_number // 10000, _number // 100 % 100, _number % 100)


def _run(work, stop):
    """Runs work() in a thread.  Ctrl-C is seen by the main thread, and only between two steps of Python: it must not
    be the one that works.  An exception in it sets stop, which ends the library's work within a tenth of a second; a
    callback of the user may take longer, so the wait for that is bounded, and work() holds what it uses."""
    ended = threading.Event()      # Thread.join cannot be trusted after an exception in it

    def whole():
        try:
            work()
        finally:
            ended.set()

    thread = threading.Thread(target=whole)
    try:
        thread.start()
        while not ended.wait(0.1):
            pass
    except BaseException:
        stop.value = 1
        if thread.ident is not None:
            ended.wait(1)
        raise


def _copied(pointer, shape, kind):
    """A copy of an array of the library's; None where it has none."""
    count = int(np.prod(shape))
    if not pointer:
        return None
    return np.frombuffer((ctypes.c_char * (count * np.dtype(kind).itemsize)).from_address(pointer),
                         kind).reshape(shape).copy()


def _answer(arrays, count, ask, points, weights=None):
    """ask(arrays), which returns a status, in a thread if there is much to do; an exception if it fails."""
    stop, status, thrown = ctypes.c_int(), [], []
    arrays.stop = ctypes.pointer(stop)

    def work():
        try:
            status.append(ask(arrays))
        except BaseException as e:
            thrown.append(e)

    if count < 1000:
        work()
    else:
        _run(work, stop)
    if thrown:
        raise thrown[0]
    if status[0]:
        raise _errors.from_status(status[0], _library.pbw_status_string(status[0]).decode(), points, weights)


def cells_of(arrays, box, lattice, periodic, what, points, weights):
    """The arrays of pbw_cells by name; what: bits of PBW_CELLS_*."""
    found, made = _Cells(), {}

    def ask(arrays):
        status = _library.pbw_python_cells(arrays, None if box is None else box.ctypes.data,
                                           None if lattice is None else lattice.ctypes.data, periodic, what, found)
        try:
            if status == 0:
                made.update(_cell_arrays(found))
        finally:
            _library.pbw_cells_free(found)
        return status

    _answer(arrays, len(points), ask, points, weights)
    return made


def gpu_cells(points, weights, box, axes, facets, threads):
    """Volumes, centroids and, with facets, neighbors and areas of points in a box, periodic along axes, by a GPU."""
    arrays = _Arrays(points.shape[1], threads, len(points), 0, points.ctypes.data,
                     None if weights is None else weights.ctypes.data)
    found, made, text = _Cells(), {}, ctypes.create_string_buffer(256)

    def ask(arrays):
        status = _library.pbw_python_gpu_cells(arrays, None if box is None else box.ctypes.data, axes, facets, found,
                                               text, len(text))
        try:
            if status == 0:
                made.update(_cell_arrays(found))
        finally:
            _library.pbw_python_gpu_free(found)
        return 0 if text.value else status

    _answer(arrays, len(points), ask, points, weights)
    if not made:
        raise _errors.Error("device='cuda': " + text.value.decode())
    return made


def _cell_arrays(c):
    made = {"volumes": _copied(c.volumes, c.cell_count, np.float64),
            "centroids": _copied(c.centroids, (c.cell_count, c.dim), np.float64),
            "first": _copied(c.first, c.cell_count + 1, np.uintp),
            "neighbors": _copied(c.neighbors, c.facet_count, np.int32),
            "areas": _copied(c.areas, c.facet_count, np.float64),
            "shifts": _copied(c.shifts, (c.facet_count, c.dim), np.int8),
            "sites": _copied(c.sites, (c.cell_count, c.dim), np.float64),
            "vertices": _copied(c.vertices, (c.vertex_count, c.dim), np.float64),
            "loop_first": _copied(c.loop_first, c.facet_count + 1, np.uintp),
            "rays": _copied(c.rays, (c.ray_count, c.dim), np.float64)}
    for name in ("first", "loop_first"):
        made[name] = None if made[name] is None else made[name].astype(np.int64)
    made["loops"] = None if made["loop_first"] is None else _copied(c.loops, made["loop_first"][-1], np.int32)
    return made


def plane(points, segments, holes, regions, triangles=None, of_triangles=None, **request):
    """The arrays of pbw_plane by name; regions: x, y, area each; triangles: those of a mesh, with their regions;
    request: fields of _PlaneRequest."""
    given, found, made = _PlaneInput(), _Plane(), {}
    for name, array in (("point", points), ("segment", segments), ("hole", holes), ("region", regions)):
        setattr(given, name + "s", array.ctypes.data)
        setattr(given, name + "_count", len(array))
    arrays, text = _Arrays(), []

    def ask(arrays):
        status = _library.pbw_python_plane(
            given, *(None if array is None else array.ctypes.data for array in (triangles, of_triangles)),
            0 if triangles is None else len(triangles), _PlaneRequest(**request), arrays.stop, found)
        try:
            if status == 0:
                made.update(_plane_arrays(found))
            else:
                text.append((status, found.what.decode()))
        finally:
            _library.pbw_plane_free(found)
        return 0

    _answer(arrays, len(points), ask, points)
    if text:
        raise _errors.from_status(*text[0], points, None)
    return made


def _plane_arrays(p):
    made = {"points": _copied(p.points, (p.point_count, 2), np.float64),
            "triangles": _copied(p.triangles, (p.triangle_count, 3), np.int32),
            "neighbors": _copied(p.neighbors, (p.triangle_count, 3), np.int32),
            "regions": _copied(p.regions, p.triangle_count, np.int32),
            "edges": _copied(p.edges, (p.edge_count, 2), np.int32),
            "edge_first": _copied(p.edge_first, p.edge_count + 1, np.uintp).astype(np.int64),
            "region_seeds": _copied(p.region_seeds, p.region_count, np.int32)}
    made["edge_segments"] = _copied(p.edge_segments, made["edge_first"][-1], np.int32)
    if made["edge_segments"] is None:
        made["edge_segments"] = np.empty(0, np.int32)
    return made


def transfer(points, triangles, values, places):
    """The values at places, an array, from those at the points of a plane's triangles: linear in each of them."""
    source, target, out = _Plane(), _Plane(), np.empty((len(places), values.shape[1]))
    source.points, source.point_count = points.ctypes.data, len(points)
    source.triangles, source.triangle_count = triangles.ctypes.data, len(triangles)
    target.points, target.point_count = places.ctypes.data, len(places)
    status = _library.pbw_plane_transfer(source, target, values, values.shape[1], out, None)
    if status:
        raise _errors.from_status(status, _library.pbw_status_string(status).decode(), places, None)
    return out


def boxed_cells(points, weights, box, lattice, periodic, what, threads):
    """The same of points alone, in a lattice or in a box; bit k of periodic: it repeats along axis k."""
    arrays = _Arrays(points.shape[1], threads, len(points), 0, points.ctypes.data,
                     None if weights is None else weights.ctypes.data)
    return cells_of(arrays, box, lattice, periodic, what, points, weights)


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

    if count < 1000 and progress is None:
        work()                     # sooner done than a thread is started
    else:
        _run(work, stop)
    if thrown:
        raise thrown[0]
    if not arrays:
        text = _library.pbw_status_string(status).decode()
        raise _errors.from_status(status.value, text, points, weights)
    return arrays


class Mesh:
    """points, weights (or None), simplices, neighbors, incident, canonical: as in pbw_mesh, -1 for PBW_NONE."""
    _STATE = "points", "weights", "simplices", "neighbors", "incident", "canonical", "threads"
    __slots__ = *_STATE, "_calls", "_stars"          # calls of nearest with few queries; stars that they share

    def __init__(self, points, weights, threads, progress, made=None):
        """made: the other arrays, where they are there already."""
        self.points, self.weights, self.threads, self._calls, self._stars = points, weights, threads, 0, None
        self.simplices, self.neighbors, self.incident, self.canonical = (
            made or _triangulate(points, weights, threads, progress))
        for array in (points, self.simplices, self.neighbors, self.incident, self.canonical):
            array.flags.writeable = False

    @staticmethod
    def empty(dim, weighted, threads):
        """That of no points."""
        ints, points = [np.empty(shape, np.int32) for shape in ((0, dim + 1), (0, dim + 1), 0, 0)], np.empty((0, dim))
        return Mesh(points, np.empty(0) if weighted else None, threads, None, ints)

    def __getstate__(self):
        return {name: getattr(self, name) for name in self._STATE}

    def __setstate__(self, state):
        """Takes the arrays of a pickle if they are a triangulation: the library follows their indices."""
        if isinstance(state, tuple):                 # of older versions
            state = state[1]
        try:
            for name in self._STATE:
                setattr(self, name, state[name])
            self._calls, self._stars = 0, None
            self._check()
        except (AttributeError, KeyError, TypeError) as e:
            raise ValueError("the pickle has no triangulation: %s" % e) from None

    def _check(self):
        count, dim = self.points.shape
        of_simplices = len(self.simplices), dim + 1
        for name, kind, shape in (("points", np.float64, (count, dim)), ("weights", np.float64, (count,)),
                                  ("incident", np.int32, (count,)), ("canonical", np.int32, (count,)),
                                  ("simplices", np.int32, of_simplices), ("neighbors", np.int32, of_simplices)):
            array = getattr(self, name)
            if array is None and name == "weights":
                continue
            if type(array) is not np.ndarray or array.dtype != kind or array.shape != shape or dim not in (2, 3):
                raise TypeError("%s are of another kind or shape" % name)
            setattr(self, name, np.array(array, order="C"))
            getattr(self, name).flags.writeable = False
        self.threads = min(max(int(self.threads), 0), 256)
        valid = ctypes.c_int()
        _answer(self._arrays(), count, lambda arrays: _library.pbw_python_check(arrays, valid), self.points)
        if not valid.value:
            raise TypeError("its arrays are damaged")

    def _arrays(self):
        count, dim = self.points.shape
        data = [None if a is None else a.ctypes.data for a in (self.points, self.weights, self.simplices,
                                                               self.neighbors, self.incident, self.canonical)]
        return _Arrays(dim, self.threads, count, len(self.simplices), *data)

    def find(self, queries):
        """For each query the lowest simplex that has it, or -1 - (a simplex to that side) if it is outside."""
        found, facets = np.empty(len(queries), np.int32), np.empty(len(queries), np.int32)
        _answer(self._arrays(), len(queries),
                lambda arrays: _library.pbw_python_locate(arrays, queries, len(queries), found, facets), queries)
        return found

    def find_by_trying(self, queries):
        """The same, -1 if it is outside."""
        found = np.empty(len(queries), np.int32)
        _library.pbw_python_try_all(self._arrays(), queries, len(queries), found)
        return found

    def nearest(self, queries, k):
        """The k nearest points of each query, -1 where there are fewer, and their distances.

        Without stars each call takes time in proportion to the points.  To make stars takes as long as about 20 such
        calls: after 20 with few queries they are made and kept."""
        count = len(queries)
        found, distances = np.empty((count, k), np.int32), np.empty((count, k))
        self._calls += count < len(self.points) // 8
        if self._calls > 20 and self._stars is None and len(self.simplices) > 0:
            first, items, _ = self._lists(len(self.points), _library.pbw_python_stars, self.points)
            self._stars = first.astype(np.uintp), items
        stars = [array.ctypes.data for array in self._stars] if self._stars else (None, None)
        _answer(self._arrays(), count,
                lambda arrays: _library.pbw_python_nearest(arrays, *stars, queries, count, k, found, distances),
                queries)
        return found, distances

    def _lists(self, count, ask, queries):
        """first, items and values (or None) of the lists of `count` queries that ask(arrays, lists) makes."""
        lists, made = _Lists(), []

        def work(arrays):
            status = ask(arrays, lists)
            try:
                if status == 0:
                    first = _copied(lists.first, count + 1, np.uintp).astype(np.int64)
                    made.extend([first, _copied(lists.item, first[-1], np.int32),
                                 _copied(lists.value, first[-1], np.float64)])
            finally:
                _library.pbw_lists_free(lists)
            return status

        _answer(self._arrays(), count, work, queries)
        return made

    def coordinates(self, queries, scheme):
        """indptr, points and weights: those of query i are from indptr[i] to indptr[i + 1]."""
        return self._lists(len(queries), lambda arrays, lists: _library.pbw_python_coordinates(
            arrays, queries, len(queries), scheme, lists), queries)

    def cells(self, what):
        return cells_of(self._arrays(), None, None, 0, what, self.points, self.weights)

    def stars(self):
        """indptr and indices of the neighbours of each point, ascending."""
        first, items, _ = self._lists(len(self.points), _library.pbw_python_stars, self.points)
        if first[-1] >= 2 ** 31:
            raise MemoryError("more than 2^31 - 1 neighbours of %d points" % len(self.points))
        keys = np.repeat(np.arange(len(self.points), dtype=np.int64) << 32, np.diff(first)) | items
        keys.sort()                                  # of point and neighbour
        return first.astype(np.int32), (keys & 0xffffffff).astype(np.int32)
