"""Exact Delaunay and regular triangulations and their cells for NumPy, with the interface of scipy.spatial.

    import numpy, pbw
    points = numpy.random.rand(1000000, 3)
    tri = pbw.Delaunay(points)                       # or with weights=, which SciPy has not
    tri.simplices, tri.neighbors, tri.find_simplex([0.5, 0.5, 0.5])
    tri.nearest([[0.5, 0.5, 0.5]], k=8)              # distances, points
    tri.simplices[tri.alpha_shape(0.05)]             # circumradius at most 0.05; longest=: no edge longer
    scipy.interpolate.LinearNDInterpolator(tri, values)
    pbw.interpolate(points, values, xi, method="sibson")
    live = pbw.Live(points)                          # points that are inserted, removed and moved
    live.move([0, 1], [[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]]); live.commit()
    pbw.Voronoi(points).regions                      # as scipy.spatial.Voronoi
    pbw.power_cells(points, weights, box=[(0, 0, 0), (1, 1, 1)], periodic="xyz").volumes
    pbw.lloyd(points, steps=20)                      # or box=, periodic=; lattice= for triclinic boxes
    pbw.triangulate(dict(vertices=v, segments=s, holes=h), "pq30a0.1")     # as the package triangle has it
    pbw.triangulate(dict(vertices=v, triangles=t, triangle_attributes=r), "r", smooth="odt")     # regions stay
    pbw.polygon([outline, hole])                     # triangles of a polygon with holes
    pbw.check_surface(vertices, faces).crossings     # pairs of triangles that meet; other faults
    solid = pbw.solid(vertices, faces, size=0.1)     # tetrahedra inside a closed surface
    closed = pbw.wrap(vertices, faces)               # a closed surface around any model, and tetrahedra inside
    better = pbw.improve(points, tets, target=30)    # any tetrahedra: dihedral angles of 30 to 150 degrees
    meshio.Mesh(solid.points, {"tetra": solid.tets}).write("solid.vtu")

Needs NumPy; no SciPy.  Two ways to have it:
    pip install ./examples/python                    # from the source tree: a C compiler, no network
    make && PYTHONPATH=examples/python python3       # without installing: finds build/libpbw_python.so
PBW_LIBRARY in the environment names another library file.

What is different from SciPy
  * All answers are exact.  Points are not dropped or merged for being nearly coplanar or nearly equal, simplices may
    be as thin as the points make them, and a lattice is tiled without overlaps.  `coplanar` has duplicates only.
  * Simplices are positively oriented in 3D as in 2D; facets of `convex_hull` are turned outward.
  * find_simplex gives the lowest of the simplices that a point on a common face belongs to.  tol is 0 unless given.
  * Cocircular and cospherical points: any triangulation is right; ours depends on the set of points alone.
  * 2D and 3D only, no furthest_site.  qhull_options have no effect; Qu, QG and QV, which ask for other simplices, are
    refused.  QJ moves no point: a duplicate stays one.
  * add_points keeps numbers of points, not of simplices; restart=True gives the same triangulation.  It takes
    weights= where the triangulation has weights.
  * Arrays are copies, made at first use: what is written to them changes no later find_simplex.
  * Voronoi merges vertices that coincide exactly, and no others.  Vertices, ridges and regions come in another order.
    In 3D there are ridges of one vertex and -1, wedges to infinity, which Qhull leaves out; where more than three
    points of the hull are in one plane, some of these have no area.
  * paraboloid_scale is 1 and paraboloid_shift is 0: `equations` are those of the plain lift |p|^2 - weight.
"""
from ._cells import Cells, Voronoi, lloyd, power_cells
from ._delaunay import Delaunay, tsearch
from ._errors import Error, QhullError
from ._interpolate import interpolate
from ._library import version as __version__
from ._live import Changes, Live
from ._plane import polygon, triangulate
from ._surface import SurfaceFaults, check_surface
from ._tets import Tets, fill, improve, solid
from ._wrap import Wrap, wrap

__all__ = ["Cells", "Changes", "Delaunay", "Error", "Live", "QhullError", "SurfaceFaults", "Tets", "Voronoi", "Wrap",
           "check_surface", "fill", "improve", "interpolate", "lloyd", "polygon", "power_cells", "solid",
           "triangulate", "tsearch", "wrap", "__version__"]
