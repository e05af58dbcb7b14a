"""Panels of a stretch, short where its springs move and longer later, with nodes on which signals are polynomials."""

from __future__ import annotations

import numpy as np

from stages.analytic.model.walker import Vector

#: Nodes of a panel (Gauss), length of the first panel in times of the legs' fastest motion, growth from one to the
#: next, and the longest one in pendulum times.
NODES, FIRST, GROWTH, LONGEST = 6, 1.2, 2.0, 0.35
#: Panels of a walker without springs are all of the longest kind.
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(NODES)


def panel_edges(duration: float, fastest: float) -> Vector:
    """Edges (p + 1,) of the panels of a stretch, from 0 to `duration`; `fastest` rate of the springs, 0 for none."""
    length = min(FIRST / fastest, LONGEST) if fastest > 0.0 else LONGEST
    edges = [0.0]
    while edges[-1] < duration:
        edges.append(edges[-1] + length)
        length = min(length * GROWTH, LONGEST)
    scale = duration / edges[-1]
    return np.array(edges) * scale


def panel_nodes(edges: Vector) -> Vector:
    """The nodes of all panels, rising, shape (p * NODES,)."""
    middle, half = 0.5 * (edges[1:] + edges[:-1]), 0.5 * np.diff(edges)
    nodes: Vector = (middle[:, None] + half[:, None] * POINTS).ravel()
    return nodes


def to_powers() -> np.ndarray:
    """The matrix (NODES, NODES) from values at the nodes to coefficients of powers of s in [-1, 1], lowest first."""
    return np.linalg.inv(np.vander(POINTS, increasing=True))


TO_POWERS = to_powers()
