"""The benchmark beside CommonRoad, without CommonRoad."""

from __future__ import annotations

import math
import subprocess
from typing import Any

import pytest

from benchmarks import bench_commonroad
from benchmarks.bench_commonroad import CAR, PERIOD, SECONDS, drive, manoeuvre, run


def test_the_manoeuvre_stays_where_single_track_tyres_are_linear() -> None:
    asked = manoeuvre()
    assert len(asked["steer"]) == len(asked["accel"]) + 1 == round(SECONDS / PERIOD) + 1
    fastest = asked["speed"] + max(math.fsum(asked["accel"][:k]) * PERIOD for k in range(len(asked["accel"])))
    lateral = max(abs(angle) for angle in asked["steer"]) * fastest**2 / CAR["wheelbase"]
    assert lateral < 6.0  # m/s^2


def test_ours_drives_the_slalom_at_ten_metres_a_second() -> None:
    speed, x, y = drive(CAR, manoeuvre())
    assert speed > 0.0
    # 10 m/s for 20 s and what speeding up brings: the integral of sin(0.4 t)/0.4 terms, 1/0.16 (0.4 t - sin 0.4 t)
    straight = 200.0 + (0.4 * SECONDS - math.sin(0.4 * SECONDS)) / 0.16
    assert 0.9 * straight < math.hypot(x, y) < straight


def test_a_peer_that_cannot_be_installed_is_one_row_that_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*args: Any, **kwargs: Any) -> None:
        raise subprocess.CalledProcessError(1, "pip")

    monkeypatch.setattr(bench_commonroad.subprocess, "run", refuse)
    monkeypatch.setattr(bench_commonroad.venv, "create", lambda *args, **kwargs: None)
    (row,) = run()
    assert row.peer is None
    assert "commonroad-vehicle-models" in row.note
    assert "could not be installed" in row.note
