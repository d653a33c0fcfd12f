"""Triangles as small as a size function asks: h(x) = min(largest, min over regions of size + growth · distance)."""

import numpy as np


def wanted(points, sizes):
    """h at points (n × 2)."""
    least = np.full(len(points), np.inf if sizes["largest"] is None else sizes["largest"])
    for region in sizes["regions"]:
        (kind, part), = region.items()
        if kind == "ball":
            distance = np.linalg.norm(points - np.array(part["centre"]), axis=1) - part["radius"]
        else:
            lower, upper = np.array(part["lower"]), np.array(part["upper"])
            distance = np.linalg.norm(np.maximum(np.maximum(lower - points, points - upper), 0.0), axis=1)
        least = np.minimum(least, part["size"] + sizes["growth"] * np.maximum(distance, 0.0))
    return least


def refined(mesh, sizes):
    """Divide triangles of a mesh of scikit-fem until none is larger than asked: the edge of a square of two
    triangles is its size, asked for at the corners and in the middle."""
    while True:
        corners = mesh.p.T[mesh.t.T]
        edges = corners[:, 1:] - corners[:, :1]
        size = np.sqrt(abs(edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]))
        asked = wanted(corners.reshape(-1, 2), sizes).reshape(-1, 3).min(axis=1)
        asked = np.minimum(asked, wanted(corners.mean(axis=1), sizes))
        marked = np.flatnonzero(size > asked * (1.0 + 1e-9))
        if not len(marked):
            return mesh
        mesh = mesh.refined(marked)


def counter_clockwise(mesh):
    """Nodes (n × 2) and triangles (t × 3) of a mesh."""
    nodes, triangles = mesh.p.T, mesh.t.T.copy()
    a, b, c = (nodes[triangles[:, k]] for k in range(3))
    turned = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0] < 0.0
    triangles[turned] = triangles[turned][:, [0, 2, 1]]
    return nodes, triangles
