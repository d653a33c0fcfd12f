"""Writes the meshes beside it with the Python package gmsh (4.15.2): python3 make.py, in this folder."""

import gmsh


def make(geometry, out, version, binary=0, order=1, parts=0, edit=None):
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.open(geometry)
    gmsh.model.mesh.generate(2)
    if order > 1:
        gmsh.model.mesh.setOrder(order)
    if edit:
        edit()
    if parts:
        gmsh.option.setNumber("Mesh.PartitionCreateTopology", 1)
        gmsh.option.setNumber("Mesh.PartitionCreatePhysicals", 0)
        gmsh.model.mesh.partition(parts)
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.Binary", binary)
    gmsh.write(out)
    gmsh.finalize()


def twice():
    gmsh.model.addPhysicalGroup(1, [4, 1], 9, "left")


for version in (2.2, 4.1):
    for binary, name in ((0, "ascii"), (1, "binary")):
        make("channel.geo", f"channel-{version}-{name}.msh", version, binary)
make("channel.geo", "channel-partitioned.msh", 4.1, parts=2)
make("channel.geo", "channel-partitioned-2.2.msh", 2.2, parts=2)
make("channel.geo", "channel-second-order.msh", 4.1, order=2)
make("channel.geo", "channel-overlap.msh", 4.1, edit=twice)
make("channel.geo", "channel-overlap-2.2.msh", 2.2, edit=twice)
make("quads.geo", "quads.msh", 4.1)
make("quads.geo", "quads-second-order.msh", 2.2, binary=1, order=2)
make("two.geo", "two.msh", 4.1)
make("two.geo", "two-2.2.msh", 2.2)
make("bare.geo", "bare.msh", 4.1)


def box(out, kind, version, binary=0, order=1):
    """A box of tetrahedra, prisms (triangles drawn out) or hexahedra."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.open("box.geo")
    if kind == "hexahedra":
        gmsh.model.mesh.setRecombine(2, 1)
    made = gmsh.model.occ.extrude([(2, 1)], 0, 0, 3, [4], recombine=kind != "tetrahedra")
    gmsh.model.occ.synchronize()
    volume = [tag for dimension, tag in made if dimension == 3]
    for _, tag in gmsh.model.getBoundary([(3, volume[0])], oriented=False):
        x, y, z = gmsh.model.occ.getCenterOfMass(2, tag)
        name = "floor" if z == 0 else "lid" if abs(z - 3) < 1e-9 else f"side at {x:g} {y:g}"
        gmsh.model.addPhysicalGroup(2, [tag], name=name)
    gmsh.model.addPhysicalGroup(3, volume, name="fluid")
    gmsh.model.mesh.generate(3)
    if order > 1:
        gmsh.model.mesh.setOrder(order)
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.Binary", binary)
    gmsh.write(out)
    gmsh.finalize()


box("box-tetrahedra.msh", "tetrahedra", 4.1)
box("box-tetrahedra-2.2.msh", "tetrahedra", 2.2, binary=1)
box("box-second-order.msh", "tetrahedra", 2.2, order=2)
box("box-prisms.msh", "prisms", 4.1, binary=1)
box("box-hexahedra.msh", "hexahedra", 4.1)
