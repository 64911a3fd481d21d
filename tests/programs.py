"""programs.py MODULE NAME.KIND...: reads these meshes of the unit square or cube with meshio or VTK and compares each
with NAME.node, .ele and .face; programs.py groups NAME: see check_groups; see programs.sh."""
import sys
import traceback

import numpy as np


def table(path, columns):
    """The head and those columns of the rows of a file of TetGen's."""
    with open(path) as lines:
        head = [int(word) for word in lines.readline().split()]
        rows = [line.split() for line in lines]
    return head, np.array([[float(word) for word in row[columns]] for row in rows])


class Expected:
    def __init__(self, name):
        (count, self.dim, *_), rows = table(name + ".node", slice(1, None))
        self.points, self.on_boundary = rows[:, :self.dim], rows[:, -1]
        _, self.cells = table(name + ".ele", slice(1, self.dim + 2))
        _, self.facets = table(name + ".face", slice(1, self.dim + 1))
        at = self.points
        assert count == len(at) and np.array_equal(self.on_boundary, ((at == 0) | (at == 1)).any(axis=1))


def sizes(points, cells):
    """Areas of triangles, volumes of tetrahedra."""
    edges = points[cells[:, 1:]] - points[cells[:, :1]]
    return np.linalg.det(edges) / (2 if edges.shape[1] == 2 else 6)


def enclosed(points, facets):
    """The measure of the boundary, and of what it encloses, positive if all turn outward."""
    at = points[facets]
    if at.shape[1] == 2:
        edge = at[:, 1] - at[:, 0]
        normals = np.stack([edge[:, 1], -edge[:, 0]], axis=1)
    else:
        normals = np.cross(at[:, 1] - at[:, 0], at[:, 2] - at[:, 0]) / 2
    outward = np.sum(normals * (at.mean(axis=1) - 0.5), axis=1)      # the domain is convex around its middle
    assert (outward > 0).all()
    return np.linalg.norm(normals, axis=1).sum(), outward.sum() / at.shape[1]


def near(a, b, tolerance=1e-12):
    assert abs(a - b) <= tolerance, (a, b)


def check_cells(want, points, cells):
    assert np.array_equal(cells, want.cells)
    size = sizes(points, cells)
    assert (size > 0).all()
    near(size.sum(), 1)


def check_facets(want, points, facets):
    assert len(facets) == len(want.facets)
    measure, inside = enclosed(points, facets)
    near(measure, 4 if want.dim == 2 else 6, 1e-6)
    near(inside, 1, 1e-6)


def check_meshio(want, path, kind):
    import meshio
    mesh = meshio.read(path, file_format="gmsh" if kind.startswith("msh") else None)
    blocks = {block.type: block.data for block in mesh.cells}
    assert len(blocks) == len(mesh.cells)
    cell, facet = ("triangle", "line") if want.dim == 2 else ("tetra", "triangle")
    points = mesh.points[:, :want.dim]
    assert (mesh.points[:, want.dim:] == 0).all()
    if kind in ("ply", "off", "obj", "stl"):
        assert list(blocks) == ["triangle"]
        if want.dim == 2:
            near(sizes(points, blocks[cell]).sum(), 1, 1e-6)         # .stl has floats
            assert len(blocks[cell]) == len(want.cells)
        else:
            check_facets(want, points, blocks[facet])
            assert len(points) == want.on_boundary.sum()
        return
    assert np.array_equal(points, want.points)
    check_cells(want, points, blocks[cell])
    if kind in ("msh", "msh2", "mesh", "su2"):
        check_facets(want, points, blocks[facet])
        assert list(blocks) == ([cell, facet] if kind == "su2" else [facet, cell])
        if kind != "su2":
            marks = mesh.cell_data["medit:ref" if kind == "mesh" else "gmsh:physical"]
            assert [set(group) for group in marks] == [{1}, {2}]
        if kind.startswith("msh"):
            assert {key: list(group) for key, group in mesh.field_data.items()} == {
                "boundary": [1, want.dim - 1], "domain": [2, want.dim]}
    elif kind == "inp":
        assert np.array_equal(mesh.point_sets["BOUNDARY"], np.nonzero(want.on_boundary)[0])
        assert len(mesh.cell_sets["DOMAIN"][0]) == len(want.cells)
    elif kind == "vtu":
        assert ((mesh.cell_data["quality"][0] > 0) & (mesh.cell_data["quality"][0] <= 1)).all()


def check_vtk(want, path, kind):
    from vtk import vtkCellSizeFilter, vtkMeshQuality, vtkXMLUnstructuredGridReader
    from vtk.util.numpy_support import vtk_to_numpy
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    grid = reader.GetOutput()
    assert grid.GetNumberOfPoints() == len(want.points) and grid.GetNumberOfCells() == len(want.cells)
    assert np.array_equal(vtk_to_numpy(grid.GetPoints().GetData())[:, :want.dim], want.points)
    assert np.array_equal(vtk_to_numpy(grid.GetPointData().GetArray("id")), np.arange(len(want.points)))
    size = vtkCellSizeFilter()
    size.SetInputData(grid)
    size.Update()
    measured = vtk_to_numpy(size.GetOutput().GetCellData().GetArray("Area" if want.dim == 2 else "Volume"))
    assert (measured > 0).all()
    near(measured.sum(), 1)
    quality = vtkMeshQuality()                       # Verdict's aspect Frobenius is one over the mean ratio
    quality.SetInputData(grid)
    quality.SetTriangleQualityMeasureToAspectFrobenius()
    quality.SetTetQualityMeasureToAspectFrobenius()
    quality.Update()
    data = quality.GetOutput().GetCellData()
    product = vtk_to_numpy(data.GetArray("Quality")) * vtk_to_numpy(data.GetArray("quality"))
    assert np.abs(product - 1).max() < 1e-12, product


def check_groups(name):
    """A cube in a cube, of two regions with six patches each, in .msh, .inp and .vtu."""
    import meshio
    want = {"region_0": 1 - 0.4 ** 3, "region_1": 0.4 ** 3}
    mesh = meshio.read(name + ".msh", file_format="gmsh")
    groups = {key: list(group) for key, group in mesh.field_data.items()}
    assert groups == {"edges": [1, 1], **{"patch_%d" % i: [i + 1, 2] for i in range(12)},
                      "region_0": [1, 3], "region_1": [2, 3]}, groups
    of = {(block.type, int(tag[0])): block.data for block, tag in zip(mesh.cells, mesh.cell_data["gmsh:physical"])
          if len(set(tag)) == 1}
    assert len(of) == len(mesh.cells) == 15
    for i in range(2):
        near(sizes(mesh.points, of["tetra", i + 1]).sum(), want["region_%d" % i])
    areas = []
    for i in range(12):
        at = mesh.points[of["triangle", i + 1]]
        areas.append(np.linalg.norm(np.cross(at[:, 1] - at[:, 0], at[:, 2] - at[:, 0]), axis=1).sum() / 2)
    assert np.allclose(sorted(areas), [0.16] * 6 + [1] * 6, rtol=0, atol=1e-12), areas
    at = mesh.points[of["line", 1]]
    near(np.linalg.norm(at[:, 1] - at[:, 0], axis=1).sum(), 12 + 4.8)
    solver = meshio.read(name + ".inp")
    for i in range(2):
        cells = solver.cells[0].data[solver.cell_sets["region_%d" % i][0]]
        near(sizes(solver.points, cells).sum(), want["region_%d" % i])
    for i in range(12):
        points = set(solver.point_sets["patch_%d" % i])
        assert len(points) == len(np.unique(of["triangle", i + 1])), i
    view = meshio.read(name + ".vtu")
    blocks = dict(zip((block.type for block in view.cells), range(2)))
    region, patch = view.cell_data["region"], view.cell_data["patch"]
    assert [(region[blocks["tetra"]] == i + 1).sum() for i in range(2)] == [len(of["tetra", i + 1]) for i in range(2)]
    assert (patch[blocks["tetra"]] == 0).all()
    assert [(patch[blocks["triangle"]] == i + 1).sum() for i in range(12)] == [len(of["triangle", i + 1])
                                                                           for i in range(12)]


def main(module, *paths):
    if module == "groups":
        check_groups(*paths)
        return
    check = {"meshio": check_meshio, "vtk": check_vtk}[module]
    for path in paths:
        name, kind = path.rsplit(".", 1)
        try:
            check(Expected(name), path, kind)
            print("%s is right" % path)
        except Exception:
            print("%s: %s" % (path, traceback.format_exc()))


if __name__ == "__main__":
    main(*sys.argv[1:])
