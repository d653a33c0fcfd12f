"""Write the mesh of a cylinder across a duct (DFG 3D-1Z) with gmsh: python3 duct-cylinder.py

Duct 2.5 m x 0.41 m x 0.41 m, cylinder of diameter 0.1 m along z at (0.5, 0.2): triangles of its section, drawn out
over layers that are thin at both walls, each prism cut into tetrahedra.
Physical surfaces: inlet, outlet, walls, cylinder; physical volume: fluid.
"""

import math

import gmsh


def layers(count):
    """Ends of layers over a unit height, thin at both ends."""
    return [0.5 - 0.5 * math.cos(math.pi * (k + 1) / count) for k in range(count)]


def write(path, on_cylinder, behind, far, count):
    """Cell size at the cylinder, in its near wake, and in the rest of the duct [m]; layers."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    geometry = gmsh.model.occ
    section = geometry.addRectangle(0, 0, 0, 2.5, 0.41)
    disk = geometry.addDisk(0.5, 0.2, 0, 0.05, 0.05)
    geometry.cut([(2, section)], [(2, disk)])
    heights = layers(count)
    made = geometry.extrude([(2, section)], 0, 0, 0.41, [1] * count, heights)
    geometry.synchronize()
    volume = [tag for dimension, tag in made if dimension == 3]
    of = {"inlet": [], "outlet": [], "walls": [], "cylinder": []}
    for _, tag in gmsh.model.getBoundary([(3, volume[0])], oriented=False):
        x, y, _ = gmsh.model.occ.getCenterOfMass(2, tag)
        box = gmsh.model.getBoundingBox(2, tag)
        if box[3] < 1e-6:
            of["inlet"].append(tag)
        elif box[0] > 2.5 - 1e-6:
            of["outlet"].append(tag)
        elif abs(x - 0.5) < 1e-3 and abs(y - 0.2) < 1e-3:
            of["cylinder"].append(tag)
        else:
            of["walls"].append(tag)
    for name, tags in of.items():
        gmsh.model.addPhysicalGroup(2, tags, name=name)
    gmsh.model.addPhysicalGroup(3, volume, name="fluid")
    ring = [tag for _, tag in gmsh.model.getBoundary([(2, section)], oriented=False)
            if gmsh.model.getType(1, tag) != "Line"]
    field = gmsh.model.mesh.field
    distance = field.add("Distance")
    field.setNumbers(distance, "CurvesList", ring)
    field.setNumber(distance, "Sampling", 200)
    near = field.add("Threshold")
    for name, value in [("InField", distance), ("SizeMin", on_cylinder), ("SizeMax", far),
                        ("DistMin", 0.0), ("DistMax", 0.3)]:
        field.setNumber(near, name, value)
    wake = field.add("Box")
    for name, value in [("VIn", behind), ("VOut", far), ("XMin", 0.42), ("XMax", 0.75),
                        ("YMin", 0.1), ("YMax", 0.3), ("Thickness", 0.3)]:
        field.setNumber(wake, name, value)
    smallest = field.add("Min")
    field.setNumbers(smallest, "FieldsList", [near, wake])
    field.setAsBackgroundMesh(smallest)
    for name in ["FromPoints", "FromCurvature", "ExtendFromBoundary"]:
        gmsh.option.setNumber("Mesh.MeshSize" + name, 0)
    gmsh.option.setNumber("Mesh.Algorithm", 6)
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.option.setNumber("Mesh.Binary", 1)
    gmsh.model.mesh.generate(3)
    gmsh.write(path)
    print(path, len(gmsh.model.mesh.getNodes()[0]), "nodes")
    gmsh.finalize()


write("duct-cylinder.msh", 0.007, 0.014, 0.08, 14)
