"""What every effect of the catalogue must do, inherited by each new file."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from vehicle_models import model

from vehicle.messages import FloatArray, VehicleState
from vehicle.model.effect import Effect
from vehicle.model.effect_catalogue import catalogue
from vehicle.model.plant import Plant
from vehicle.model.vehicle_model import Base, VehicleModel

EFFECTS = [e for e in catalogue().values() if e.slot != "perception"]
BASES: tuple[Base, ...] = ("kinematic_bicycle", "dynamic_bicycle")


def _drive(found: VehicleModel, *, keep_neutral: bool = False) -> FloatArray:
    """20 s of everything: launch, turns of both signs, lift-off, braking to standstill, launch again."""
    t = np.arange(400) * 0.05
    commands = np.zeros((400, 6))
    commands[:, 0] = 0.15 * np.sin(0.9 * t) + 0.05 * np.sign(np.sin(2.3 * t))
    commands[:, 1] = np.where(t < 6, 2.0, np.where(t < 7, 0.2, np.where(t < 8, 0.0, np.where(t < 13, -3.0, 1.5))))
    commands[:, 4] = np.where(t < 10, 8.0, 2.0)
    car = Plant(found, keep_neutral=keep_neutral)
    car.reset(VehicleState(t=0.0, x=1.0, y=2.0, yaw=0.3, v=0.0))
    return car.drive(commands, 50, measured=True)


def _base_of(effect: Effect) -> Base:
    return "kinematic_bicycle" if "kinematic_bicycle" in effect.base else "dynamic_bicycle"


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda e: e.name)
def test_neutral_values_are_the_base_model(effect: Effect) -> None:
    for base in BASES:
        if base in effect.base:
            plain = model(base)
            with_effect = plain.with_effect(effect, effect.neutral())
            assert np.abs(_drive(with_effect, keep_neutral=True) - _drive(plain)).max() < 1e-12


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda e: e.name)
def test_finite_over_the_whole_range(effect: Effect) -> None:
    for share in (0.0, 0.5, 1.0):
        values = {k.name: k.low + share * (k.high - k.low) for k in effect.parameters}
        assert np.isfinite(_drive(model(_base_of(effect)).with_effect(effect, values))).all()


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda e: e.name)
def test_middle_of_the_range_shows_in_the_motion(effect: Effect) -> None:
    values = {k.name: k.low + 0.7 * (k.high - k.low) for k in effect.parameters}
    plain = model(_base_of(effect))
    if effect.name == "speed_controller":
        plain = replace(plain, inputs=replace(plain.inputs, longitudinal=("speed_cmd",)))
    if effect.name == "speed_limit":
        controlled = plain.with_effect("speed_controller", {"kp": 1.0})
        plain = replace(controlled, inputs=replace(controlled.inputs, longitudinal=("speed_cmd",)))
    if effect.name == "motor_torque":
        values |= {"torque": 40.0}
    if effect.name == "wheel_radius":  # the middle is neutral
        values = {"ratio": 1.05}
    if effect.name == "road_profile":  # one that stands on the way
        values = {"height": 1.0, "x": 10.0, "y": 5.0, "length": 10.0}
    if effect.name in ("power_limit", "brake_limit", "drive_torque_limit", "speed_limit", "tyre_saturation"):
        values = {k.name: k.low for k in effect.parameters}
    if effect.name in ("steer_angle_limit", "steer_rate_limit"):
        values = {"limit": 0.1}
    changed = np.abs(_drive(plain.with_effect(effect, values)) - _drive(plain))
    assert changed.max() > 1e-3


@pytest.mark.parametrize("effect", catalogue().values(), ids=lambda e: e.name)
def test_description_is_complete(effect: Effect) -> None:
    assert effect.name in effect.function.__code__.co_filename
    assert all((effect.physics, effect.equation, effect.source, effect.reveals))
    for key in effect.parameters:
        assert all((key.unit, key.meaning))
        assert key.low < key.high
        assert key.least > 0.0
        assert key.neutral == 0.0 or math.isinf(key.neutral) or key.minimum <= key.neutral <= key.maximum


def test_ties_name_effects_of_the_published_catalogue(shared_dir: object) -> None:
    import re
    from pathlib import Path

    text = (Path(str(shared_dir)) / "DIAGNOSIS.md").read_text(encoding="utf-8")
    published = set(re.findall(r"`([a-z_]+)`", text)) | set(catalogue())
    for effect in catalogue().values():
        assert set(effect.ties) <= published, effect.name


def test_the_published_catalogue_is_complete_with_its_keys(shared_dir: object) -> None:
    import re
    from pathlib import Path

    text = (Path(str(shared_dir)) / "DIAGNOSIS.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (`[a-z_`, ]+) \| `?([A-Za-z0-9_, ]+?)`? \|", text, re.MULTILINE)
    assert len(rows) > 45
    for names, keys in rows:
        for name in re.findall(r"`([a-z_]+)`", names):
            known = [k.name for k in catalogue()[name].parameters]
            # Later than the table; without them a file means what it meant.
            later = {"headwind": ("heading",), "brake_lag": ("release",), "drive_lag": ("brakes",)}
            later["brake_gain"] = ("motor",)
            later["lift_off_braking"] = ("braking", "rise", "fade", "lag", "drive", "blend")
            later["detection_misses"] = ("slope", "pedestrian", "bicycle")
            assert known == [*keys.split(", "), *later.get(name, ())], name


def test_order_of_effects_in_the_file_does_not_change_the_motion() -> None:
    one = model(effects={"drive_lag": {"tau": 0.3}, "brake_limit": {"limit": 2.0}, "steer_lag": {"tau": 0.2}})
    other = model(effects={"steer_lag": {"tau": 0.2}, "brake_limit": {"limit": 2.0}, "drive_lag": {"tau": 0.3}})
    assert (_drive(one) == _drive(other)).all()
