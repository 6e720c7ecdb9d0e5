"""Numbers of effects that a sentence or an equation gives."""

from __future__ import annotations

import re
from types import SimpleNamespace
from typing import Any

import pytest

from vehicle.model import shown_by
from vehicle.model.effect_catalogue import find_effect

DRIVES = {name: value for name, value in vars(shown_by).items() if isinstance(value, tuple) and len(value) == 3
          and isinstance(value[1], float)}  # fmt: skip


@pytest.mark.parametrize("drive", DRIVES.values(), ids=DRIVES)
def test_how_a_car_must_have_been_driven_is_said_with_the_number_that_is_asked_for(drive: Any) -> None:
    _, least, words = drive
    number = re.search(r"\d+(\.\d+)?", words)
    assert number is not None
    assert float(number[0]) == least


@pytest.mark.parametrize(("v", "gear"), [(3.5, 2.0), (3.62, 2.0), (3.64, 3.0), (3.9, 3.0)])
def test_each_gear_is_at_least_a_tenth_longer_than_the_one_before(v: float, gear: float) -> None:
    """From the first at 3 m/s with a step of 1.1, which gets no smaller: 3.3, then 3.63 m/s."""
    p = SimpleNamespace(T=0.4, v1=3.0, step=1.1, demand=0.0, cut=0.8, fall=0.0)
    x: Any = SimpleNamespace(t=7.0, t_start=0.0, settle=0.0, dt=0.1, accel_lead=0.0, vx=v, accel=0.0)
    m = SimpleNamespace(gear=2.0, left=0.0)
    find_effect("gear_changes").function(x, p, m)
    assert m.gear == gear
