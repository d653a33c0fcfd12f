"""Nested dissection: an order of the unknowns in which a factorisation stays sparse.

A set of unknowns is cut in two by a line across its longer side; those next to the line, which keep the
halves apart, come last. SuperLU's own orderings fill ten times as much on this saddle point.
"""

import numpy as np

LEAF = 48


def nested_dissection(pattern, place, last):
    """Order of the unknowns of a symmetric ``pattern`` (CSR) at ``place`` (N × 2); in each block those
    with ``last`` set, of which the diagonal is empty until the others are gone, come last."""
    parts = []
    # Reversed at the end: a separator is put down before the halves it keeps apart.
    todo = [np.arange(len(place))]
    while todo:
        part = todo.pop()
        if len(part) <= LEAF:
            parts.append(part)
            continue
        axis = np.ptp(place[part], axis=0).argmax()
        along = place[part, axis]
        low = along <= np.median(along)
        if low.all():
            parts.append(part)
            continue
        left, right = part[low], part[~low]
        side = np.zeros(len(place))
        side[right] = 1.0
        touching = pattern[left] @ side > 0.0
        parts.append(left[touching])
        todo += [left[~touching], right]
    blocks = [block[np.argsort(last[block], kind="stable")] for block in reversed(parts)]
    return np.concatenate(blocks)
