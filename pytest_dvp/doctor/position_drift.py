"""Positions that drift away and come back while the car's own speed and heading tell another way: a fix that was lost.

A log that states how well the position is known (`position_sigma`) says it itself; of any other one the way driven is
integrated from speed and heading and held against the positions, window by window.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from openscenario.findings import Findings
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.lost_fix import SIGMA, lost_fix, lost_for

WINDOW = 5.0  # s: a drift of centimetres a second grows to decimetres, the error of a wheel's speed does not
STEP = 0.1  # s between windows, and the finest grid
LEAST = 0.2  # m in a window: less is no harm to a comparison on segments of 5 s; chosen
TIMES = 8.0  # the median of the log's own windows: slip, slopes and noise make those, and far tails
SHORTEST = 30.0  # s of driving by which the usual error of a window is known
LATEST = 1.0  # s by which positions may come later than speed and heading: a delay is an effect, no drift
HOLE = 0.2  # s without a value: a straight line across it is no measurement
FAST, SLIDE = 3.0, 0.15  # m/s and rad beyond which a car slides: tyres of a road car slip by 0.1 rad at their limit
DRIVEN = 1.0  # m in a window: a standing car's place tells nothing of its speed


def check_lost_fix(log: Log, file: str, findings: Findings) -> None:
    """What the log's own `position_sigma` says of stretches without a fix."""
    lost = lost_fix(log.columns)
    if not lost.any():
        return
    sigma = log.columns[SIGMA]
    first = float(log.t[int(np.argmax(lost))])
    findings.add(
        "log.lost_fix", file, None, f"column {SIGMA}",
        f"the position is stated to be worse than usual for {lost_for(log):.3g} s, first at t = {first:.6g} s",
        found=f"up to {float(np.nanmax(sigma)):.3g} m, {float(np.nanquantile(sigma, 0.1)):.3g} m at best",
        hint="x, y, yaw and v of these rows are left out of comparisons", severity="warning",
    )  # fmt: skip


def check_drift(log: Log, file: str, findings: Findings) -> None:
    """Positions that leave the way that speed and heading tell, in a log that does not state how well it knows them."""
    if SIGMA in log.columns or any(finding.code == "log.position_jump" for finding in findings.found):
        return
    found = _apart(log)
    if found is None:
        return
    t, apart = found
    usual = float(np.median(apart))
    beyond = apart > max(TIMES * usual, LEAST)
    if not beyond.any():
        return
    at = t[beyond]
    parts = np.split(at, np.flatnonzero(np.diff(at) > WINDOW) + 1)
    which = f"from t = {parts[0][0]:.6g} to {parts[0][-1] + WINDOW:.6g} s"
    which += "" if len(parts) == 1 else f", and in {len(parts) - 1} more parts"
    findings.add(
        "log.position_drift", file, None, "column x",
        f"the position leaves the way that speed and heading tell by up to {float(apart.max()):.2g} m in {WINDOW:g} s, "
        + which,
        found=f"{usual:.2g} m in the median of such windows",
        hint="a position fix that was lost, a heading that was not known yet, or wheels that slipped: leave that part "
        "out, LOG@FROM:TO",
        severity="warning",
    )  # fmt: skip


def _apart(log: Log) -> tuple[FloatArray, FloatArray] | None:
    """Starts [s] of windows and by how much [m] positions and integrated motion part in each, (k,) both.

    Scale of the speed, a constant turn of the heading, the place of the antenna in the car, slip of the tyres, and by
    how much positions come later are fitted to all windows and taken out; windows in which the car slides do not count.
    None without positions, speed and heading, or of a log that is too short.
    """
    known = {name: _known(log, name) for name in ("x", "y", "v", "yaw")}
    if any(values is None for values in known.values()):
        return None
    x, y, v, yaw = (values for values in known.values() if values is not None)
    begin, end = max(part[0][0] for part in (x, y, v, yaw)), min(part[0][-1] for part in (x, y, v, yaw))
    if end - begin < SHORTEST:
        return None
    grid = np.arange(begin, end - LATEST, STEP)
    heading = np.interp(grid, yaw[0], np.unwrap(yaw[1]))
    ahead = np.exp(1j * heading)
    speed = np.interp(grid, *v) * ahead
    sideways = (
        1j * speed * np.abs(speed) * np.gradient(heading, STEP)
    )  # of an axle whose tyres slip in proportion to ay
    rows = round(WINDOW / STEP)
    told, aside = (part[rows:] - part[:-rows] for part in (_integral(speed), _integral(sideways)))
    turned, faster = (part[rows:] - part[:-rows] for part in (ahead, speed))
    placed = _near(grid, x[0]) & _near(grid, y[0])
    slides = _slides(np.interp(grid, *x) + 1j * np.interp(grid, *y), ahead)
    unknown = np.concatenate([[0], np.cumsum(slides | ~(_near(grid, v[0]) & _near(grid, yaw[0])))])
    drives = (np.abs(told) > DRIVEN) & placed[rows:] & placed[:-rows] & (unknown[rows + 1 :] == unknown[: -rows - 1])
    if np.count_nonzero(drives) * STEP < SHORTEST - WINDOW:
        return None
    columns = np.column_stack([told, 1j * told, turned, 1j * turned, aside, faster])[drives]
    late, apart = 0.0, np.zeros(len(columns))
    for _ in range(3):  # Newton's steps: a lag moves positions by the speed to first order only
        place = np.interp(grid + late, *x) + 1j * np.interp(grid + late, *y)
        apart, fitted = _left_over(columns, (place[rows:] - place[:-rows])[drives])
        late = float(np.clip(late - fitted[-1], 0.0, LATEST))
    return grid[:-rows][drives], apart


def _integral(values: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """From the first value (n,) on, in its unit times s."""
    return np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * STEP)])


def _slides(place: NDArray[np.complex128], ahead: NDArray[np.complex128]) -> NDArray[np.bool_]:
    """Where the car (n,) moves fast and not where it points: no lost fix drifts by a sixth of that speed."""
    half = round(0.5 / STEP)
    moved = np.zeros_like(place)
    moved[half:-half] = place[2 * half :] - place[: -2 * half]
    off = np.angle(moved * np.conj(ahead))
    beside = np.minimum(np.abs(off), np.pi - np.abs(off))  # it may drive backwards
    return np.asarray((np.abs(moved) > FAST) & (beside > SLIDE))


def _near(grid: FloatArray, stamps: FloatArray) -> NDArray[np.bool_]:
    """Where the grid (n,) [s] lies between two stamps (m,) [s] that are HOLE apart at most."""
    after = np.clip(np.searchsorted(stamps, grid), 1, len(stamps) - 1)
    return np.asarray(stamps[after] - stamps[after - 1] <= HOLE)


def _left_over(columns: NDArray[np.complex128], moved: NDArray[np.complex128]) -> tuple[FloatArray, FloatArray]:
    """|moved - columns @ k| (n,) and the real k that fit most rows: least squares, then without the worst tenth."""
    kept = np.ones(len(moved), dtype=np.bool_)
    apart, fitted = np.abs(moved), np.zeros(columns.shape[1])
    for _ in range(2):
        a = np.concatenate([columns[kept].real, columns[kept].imag])
        b = np.concatenate([moved[kept].real, moved[kept].imag])
        fitted = np.linalg.lstsq(a, b, rcond=None)[0]
        apart = np.abs(moved - columns @ fitted)
        kept = apart <= np.percentile(apart, 90)
    return apart, fitted


def _known(log: Log, name: str) -> tuple[FloatArray, FloatArray] | None:
    """Stamps and values of a column where it was measured; None if it was hardly."""
    values = log.columns.get(name)
    if values is None:
        return None
    seen = np.isfinite(values)
    return (log.t[seen], values[seen]) if np.count_nonzero(seen) > 20 else None
