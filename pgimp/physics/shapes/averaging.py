"""Part of the consistent mass in the averaged mass of bodies, by shape and particles per cell.

Measured by ``scripts/waves numbers``.
"""

from __future__ import annotations


def averaged_part(shape: str, per_cell: tuple[int, ...], courant: float) -> float:
    n = max(per_cell)
    mean = sum(((i + 0.5) / n - 0.5) ** 2 for i in range(n)) / n
    return (1.0 / 12.0) / (0.25 - mean) * (1.0 - courant**2)
