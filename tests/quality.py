"""quality.py REPORT MESH: compares what `pbw improve --quality` says of the tetrahedra of a mesh, or `pbw plane
--quality` of its triangles, with what others say: with VTK's vtkMeshQuality, which is Verdict, of a .vtu; or with
Gmsh's statistics, of a .pos; see programs.sh and plane.sh.  Not dihedral angles: VTK 9.1 takes other than the least
of six."""
import re
import sys

import numpy as np

VERDICT = {"volume": "Volume", "eta": "Shape", "radius ratio": "RadiusRatio", "aspect ratio": "AspectRatio",
           "aspect gamma": "AspectGamma", "edge ratio": "EdgeRatio", "scaled Jacobian": "ScaledJacobian",
           "condition": "Condition"}
VERDICT_2D = {"minimum angle": "MinAngle", "maximum angle": "MaxAngle", "radius ratio": "RadiusRatio",
              "shape": "Shape", "aspect ratio": "AspectRatio", "edge ratio": "EdgeRatio", "condition": "Condition",
              "area": "Area", "scaled Jacobian": "ScaledJacobian"}


def verdict(path):
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    types = vtk_to_numpy(reader.GetOutput().GetCellTypesArray())
    plane = (types != vtk.VTK_TETRA).all()
    for name, theirs in (VERDICT_2D if plane else VERDICT).items():
        quality = vtk.vtkMeshQuality()
        quality.SetInputData(reader.GetOutput())
        getattr(quality, "Set%sQualityMeasureTo%s" % ("Triangle" if plane else "Tet", theirs))()
        quality.Update()
        values = vtk_to_numpy(quality.GetOutput().GetCellData().GetArray("Quality"))
        yield name, values[types == (vtk.VTK_TRIANGLE if plane else vtk.VTK_TETRA)]


def gmsh(path):
    """One value per measure and corner; the corners of an element have one value."""
    with open(path) as file:
        text = file.read()
    names = re.search(r'\{("[^}]*)\};', text).group(1).replace('"', "").split(",")
    kind = "SS" if "SS(" in text else "ST"
    rows = np.array([row.split(",") for row in re.findall(kind + r"\([^)]*\)\{([^}]*)\}", text)], dtype=float)
    for i, name in enumerate(names):
        yield {"Gamma": "gamma", "SICN": "SICN" if kind == "SS" else "shape"}[name], rows[:, rows.shape[1] // 2 * i]


with open(sys.argv[1]) as report:
    said = {line.partition(" least ")[0].strip(): dict(part.rsplit(" ", 1) for part in
            ("least " + line.partition(" least ")[2].strip()).split(", ")) for line in report if " least " in line}
compared = 0
for name, values in (verdict if sys.argv[2].endswith("vtu") else gmsh)(sys.argv[2]):
    assert len(values) > 1000
    for key, value in ("least", values.min()), ("mean", values.mean()), ("most", values.max()):
        assert abs(float(said[name][key]) - value) <= 1e-5 * abs(value), (name, key, said[name][key], value)
    compared += 1
assert compared > 1, compared
