"""Vectors, rotations and small linear systems in plain Python.

Arithmetic on float64 in one order of operations: the same bits on every rank.
"""

from __future__ import annotations

from math import cos, hypot, sin, sqrt

from pgimp.physics.rigid import Triple

Matrix = tuple[float, ...]
"""Nine numbers, row by row."""


def triple(x: tuple[float, ...]) -> Triple:
    """Return the first three numbers as floats."""
    return (float(x[0]), float(x[1]), float(x[2]))


def add(a: Triple, b: Triple) -> Triple:
    """Return the sum of two vectors."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def cross(a: Triple, b: Triple) -> Triple:
    """Return the cross product of two vectors."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def matrix(turn: tuple[float, ...]) -> Matrix:
    """Return the matrix of a rotation, given by its quaternion."""
    w, x, y, z = turn
    return (
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - w * z),
        2.0 * (x * z + w * y),
        2.0 * (x * y + w * z),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - w * x),
        2.0 * (x * z - w * y),
        2.0 * (y * z + w * x),
        1.0 - 2.0 * (x * x + y * y),
    )


def turned(
    turn: tuple[float, float, float, float], by: Triple
) -> tuple[float, float, float, float]:
    """Return the quaternion of a rotation followed by one about an axis by an angle."""
    angle = hypot(*by)
    part = 0.5 if angle < 1e-8 else sin(0.5 * angle) / angle
    a, b, c, d = cos(0.5 * angle), part * by[0], part * by[1], part * by[2]
    w, x, y, z = turn
    q = (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )
    length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    return (q[0] / length, q[1] / length, q[2] / length, q[3] / length)


def solve(M: list[list[float]], b: list[float]) -> list[float]:
    """Solve a small system of linear equations."""
    n = len(b)
    rows = [[*row, value] for row, value in zip(M, b, strict=True)]
    for i in range(n):
        for k in range(i + 1, n):
            if abs(rows[k][i]) > abs(rows[i][i]):
                rows[i], rows[k] = rows[k], rows[i]
        pivot = rows[i]
        for row in rows[i + 1 :]:
            if row[i] != 0.0 and pivot[i] != 0.0:
                factor = row[i] / pivot[i]
                for j in range(i + 1, n + 1):
                    row[j] -= factor * pivot[j]
    x = [0.0] * n
    for i in reversed(range(n)):
        row, total = rows[i], rows[i][n]
        for j in range(i + 1, n):
            total -= row[j] * x[j]
        x[i] = total / row[i] if row[i] != 0.0 else 0.0
    return x
