"""Products of long vectors, in one thread: a threaded BLAS burns more time on waking up than these take."""

from __future__ import annotations

import numpy as np

from machine_code import compiled
from pytest_dvp.gap.compare.start_correction import IntArray
from pytest_dvp.logs.log_contents import FloatArray


@compiled
def square(r: FloatArray) -> float:
    """Sum of squares of r (N,), in the square of its unit."""
    total = 0.0
    for i in range(len(r)):
        total += r[i] * r[i]
    return total


@compiled
def row_products(rows: FloatArray, r: FloatArray) -> FloatArray:
    """Scalar products (p,) of r (N,) with each row of rows (p, N)."""
    found = np.zeros(len(rows))
    _fill_products(rows, r, len(rows), found)
    return found


@compiled
def gram(rows: FloatArray) -> FloatArray:
    """Scalar products (p, p) of the rows of rows (p, N) with one another."""
    p = len(rows)
    found = np.zeros((p, p))
    for j in range(p):
        _fill_products(rows, rows[j], j + 1, found[j])
    for j in range(p):
        for k in range(j):
            found[k, j] = found[j, k]
    return found


@compiled
def _fill_products(rows: FloatArray, r: FloatArray, count: int, found: FloatArray) -> None:
    """Fill found (>= count,) with the scalar products of r (N,) with the first `count` of rows (p, N).

    Six rows at a time: a sum has to wait for its last term, and the others go on meanwhile. Each is still added up in
    the order of its columns, so the same numbers come out as by one after the other.
    """
    k = 0
    while k + 6 <= count:
        a, b, c, d, e, f = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(len(r)):
            x = r[i]
            a += rows[k, i] * x
            b += rows[k + 1, i] * x
            c += rows[k + 2, i] * x
            d += rows[k + 3, i] * x
            e += rows[k + 4, i] * x
            f += rows[k + 5, i] * x
        found[k], found[k + 1], found[k + 2], found[k + 3], found[k + 4], found[k + 5] = a, b, c, d, e, f
        k += 6
    for one in range(k, count):
        total = 0.0
        for i in range(len(r)):
            total += rows[one, i] * r[i]
        found[one] = total


@compiled
def grams_of_segments(rows: FloatArray, starts: IntArray) -> FloatArray:
    """`gram` (m, p, p) of each stretch of the columns of rows (p, N): they begin at starts (m,), the first one at 0."""
    found = np.zeros((len(starts), len(rows), len(rows)))
    for s in range(len(starts)):
        end = starts[s + 1] if s + 1 < len(starts) else rows.shape[1]
        found[s] = gram(rows[:, starts[s] : end])
    return found


@compiled
def broyden_update(rows: FloatArray, step: FloatArray, change: FloatArray) -> None:
    """Turn derivatives rows (p, N) into ones that say of `step` (p,) that it makes `change` (N,), and of steps at right
    angles to it what they said before.

    Source: C. G. Broyden, Math. Comp. 19 (1965) 577.
    """
    length = 0.0
    for k in range(len(step)):
        length += step[k] * step[k]
    if length <= 0.0:
        return
    for i in range(len(change)):
        missing = change[i]
        for k in range(len(step)):
            missing -= step[k] * rows[k, i]
        missing /= length
        for k in range(len(step)):
            rows[k, i] += missing * step[k]


def orthonormal(rows: FloatArray) -> FloatArray:
    """Rows (q, N) of length 1, at right angles, that span those of rows (p, N); q <= p."""
    found: list[FloatArray] = []
    for row in rows:
        left = row.copy()
        for _ in range(2):  # twice is enough: Parlett, The Symmetric Eigenvalue Problem
            for done in found:
                left -= row_products(done[None, :], left)[0] * done
        length = square(left) ** 0.5
        if length > 1e-6 * max(square(row) ** 0.5, 1e-300):
            found.append(left / length)
    return np.array(found) if found else np.zeros((0, rows.shape[1]))
