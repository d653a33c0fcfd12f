"""Write the meshes of the cylinder benchmark (DFG 2D-1) with gmsh: python3 cylinder.py

Channel 2.2 m x 0.41 m, cylinder of diameter 0.1 m at (0.2, 0.2).
Physical curves: inlet, outlet, walls, cylinder; physical surface: fluid.
"""

import gmsh


def write(path, on_cylinder, behind, far):
    """Cell size at the cylinder, in its near wake, and in the rest of the channel [m]."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    geometry = gmsh.model.geo
    corners = [
        geometry.addPoint(x, y, 0)
        for x, y in [(0, 0), (2.2, 0), (2.2, 0.41), (0, 0.41)]
    ]
    sides = [geometry.addLine(corners[k], corners[(k + 1) % 4]) for k in range(4)]
    centre = geometry.addPoint(0.2, 0.2, 0)
    ring = [
        geometry.addPoint(0.2 + dx, 0.2 + dy, 0)
        for dx, dy in [(0.05, 0), (0, 0.05), (-0.05, 0), (0, -0.05)]
    ]
    arcs = [
        geometry.addCircleArc(ring[k], centre, ring[(k + 1) % 4]) for k in range(4)
    ]
    surface = geometry.addPlaneSurface(
        [geometry.addCurveLoop(sides), geometry.addCurveLoop(arcs)]
    )
    geometry.synchronize()
    gmsh.model.addPhysicalGroup(1, [sides[3]], name="inlet")
    gmsh.model.addPhysicalGroup(1, [sides[1]], name="outlet")
    gmsh.model.addPhysicalGroup(1, [sides[0], sides[2]], name="walls")
    gmsh.model.addPhysicalGroup(1, arcs, name="cylinder")
    gmsh.model.addPhysicalGroup(2, [surface], name="fluid")

    field = gmsh.model.mesh.field
    distance = field.add("Distance")
    field.setNumbers(distance, "CurvesList", arcs)
    field.setNumber(distance, "Sampling", 200)
    near = field.add("Threshold")
    field.setNumber(near, "InField", distance)
    field.setNumber(near, "SizeMin", on_cylinder)
    field.setNumber(near, "SizeMax", far)
    field.setNumber(near, "DistMin", 0.0)
    field.setNumber(near, "DistMax", 0.25)
    wake = field.add("Box")
    for name, value in [
        ("VIn", behind), ("VOut", far), ("XMin", 0.1), ("XMax", 0.6),
        ("YMin", 0.05), ("YMax", 0.36), ("Thickness", 0.2),
    ]:
        field.setNumber(wake, name, value)
    smallest = field.add("Min")
    field.setNumbers(smallest, "FieldsList", [near, wake])
    field.setAsBackgroundMesh(smallest)
    for name in ["FromPoints", "FromCurvature", "ExtendFromBoundary"]:
        gmsh.option.setNumber(
            "Mesh.MeshSize" + name, 0
        )
    gmsh.option.setNumber("Mesh.Algorithm", 6)
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.option.setNumber("Mesh.Binary", 0)
    gmsh.model.mesh.generate(2)
    gmsh.write(path)
    print(path, len(gmsh.model.mesh.getNodes()[0]), "nodes")
    gmsh.finalize()


write("cylinder.msh", 0.0013, 0.005, 0.011)
write("cylinder-coarse.msh", 0.004, 0.012, 0.025)
# To refine from: the circle as round as that of the fine mesh, the channel coarse.
write("cylinder-root.msh", 0.0013, 0.05, 0.05)
