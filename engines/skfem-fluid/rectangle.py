"""The rectangle of a scene as nodes and triangles, numbered as the built-in fluid numbers them."""

import numpy as np


def rectangle(part):
    """Nodes (n × 2) row by row from the bottom, and triangles (t × 3), counter-clockwise."""
    columns, rows = part["cells"]
    x, y = (lines(part["lower"][d], part["upper"][d], part["cells"][d], part["grading"][d]) for d in range(2))
    nodes = np.column_stack([np.tile(x, rows + 1), np.repeat(y, columns + 1)])
    i, j = (index.ravel() for index in np.meshgrid(np.arange(columns), np.arange(rows)))
    a = j * (columns + 1) + i
    b, c = a + 1, a + columns + 1
    d = c + 1
    even = (i + j) % 2 == 0
    if part["diagonals"] == "uniform":
        even[:] = True
    first = np.where(even, [a, b, d], [a, b, c]).T
    second = np.where(even, [a, d, c], [b, d, c]).T
    return nodes, np.stack([first, second], axis=1).reshape(-1, 3)


def lines(lower, upper, cells, grading):
    """Cell k from the nearer end has the size s·r^(k/m): m the middle cell, r the grading."""
    k = np.arange(cells)
    middle = max((cells - 1) // 2, 1)
    size = grading ** (np.minimum(k, cells - 1 - k) / middle)
    at = lower + (upper - lower) * np.concatenate([[0.0], np.cumsum(size)]) / size.sum()
    at[-1] = upper
    return at
