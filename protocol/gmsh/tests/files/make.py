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
