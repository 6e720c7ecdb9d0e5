"""Input maps: from the columns of a log to what the kernel is told."""

from __future__ import annotations

import numpy as np
import pytest

from vehicle.model.command_inputs import INPUT_KEYS, Inputs, command_table
from vehicle.model.errors import ModelError
from vehicle.model.model_file import model_text, parse_model
from vehicle.model.open_loop import Replay

T = np.arange(200) * 0.02
AX, STEER = 5, 7


def model(inputs: str) -> object:
    return parse_model(f"[inputs]\n{inputs}\n[parameters]\nwheelbase = 2.0\n")


def push(inputs: str, **columns: float) -> float:
    """Acceleration [m/s^2] that these columns give at 10 m/s."""
    given = {name: np.full(200, value) for name, value in columns.items()}
    replay = Replay(model(inputs), T, {"steer_cmd": np.zeros(200), **given})  # type: ignore[arg-type]
    return float(replay.run(starts=np.array([0]), states=np.array([[0, 0, 0, 10.0, 0, 0]]))[5, AX])


def test_pedals_ask_for_their_share_of_full_throttle_and_brake() -> None:
    pedals = 'longitudinal = "throttle_cmd + brake_cmd"\nfull_throttle = 4.0\nfull_brake = 8.0'
    assert push(pedals, throttle_cmd=0.25, brake_cmd=0.0) == pytest.approx(1.0)
    assert push(pedals, throttle_cmd=0.0, brake_cmd=0.25) == pytest.approx(-2.0)


def test_brake_pressure_counts_as_its_share_of_full_pressure() -> None:
    pedals = 'longitudinal = "throttle_cmd + brake_pressure"\nfull_brake = 10.0\nfull_pressure = 4e6'
    assert push(pedals, throttle_cmd=0.0, brake_pressure=1e6) == pytest.approx(-2.5)


def test_motor_current_drives_and_brakes() -> None:
    current = 'longitudinal = "motor_current"\nfull_current = 200\nfull_throttle = 3.0\nfull_brake = 2.0'
    assert push(current, motor_current=100.0) == pytest.approx(1.5)
    assert push(current, motor_current=-100.0) == pytest.approx(-1.0)


def test_a_normalised_steering_input_has_a_scale_and_a_zero() -> None:
    found = model('steer = "steer_cmd_norm"\nlongitudinal = "v"\nsteer_zero = 0.01')
    replay = Replay(found, T, {"steer_cmd_norm": np.full(200, 0.5), "v": np.full(200, 2.0)})  # type: ignore[arg-type]
    assert replay.run()[9, STEER] == pytest.approx(0.4 * 0.5 + 0.01)
    assert replay.run({("inputs", "steer_scale"): 0.3})[9, STEER] == pytest.approx(0.3 * 0.5 + 0.01)


def test_a_model_file_keeps_its_map() -> None:
    numbers = "steer_scale = 0.37\nsteer_zero = -0.02\nfull_current = 90"
    found = model(f'steer = "steer_cmd_norm"\nlongitudinal = "motor_current"\n{numbers}')
    assert parse_model(model_text(found)) == found  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("full_current = 0", "more than 0 to 100000 A"),
        ("full_pressure = 0", "more than 0 to 1e[+]09 Pa"),
        ("full_throttle = 60", "more than 0 to 50 m/s"),
        ("full_brake = 0", "more than 0 to 50 m/s"),
        ("steer_zero = 2", "-1 to 1 rad"),
        ("steer_scale = 20", "-10 to 10 rad"),
        ("steer_scael = 0.4", "did you mean 'steer_scale'"),
        ('longitudinal = "brake_presure"', "unknown longitudinal input"),
    ],
)
def test_a_wrong_map_is_answered_with_what_is_allowed(text: str, says: str) -> None:
    with pytest.raises(ModelError, match=says):
        model(text)


def test_both_ends_of_a_range_are_allowed() -> None:
    for low, high in (("steer_scale = -10", "steer_scale = 10"), ("steer_zero = -1", "steer_zero = 1")):
        assert model(low) != model(high)
    model("full_throttle = 50\nfull_brake = 50\nfull_current = 1e5\nfull_pressure = 1e9")


def test_every_scale_that_can_be_fitted_is_a_number_of_the_inputs() -> None:
    assert all(isinstance(getattr(Inputs(), key.name), float) for key in INPUT_KEYS)


def test_held_and_measured_columns() -> None:
    columns = {"steer": np.array([0.0, 0.1, 0.3]), "speed_cmd": np.array([1.0, np.nan, 2.0])}
    table, slopes = command_table(Inputs(steer="steer", longitudinal=("speed_cmd",)), np.arange(3.0), columns)
    assert slopes[:, 0] == pytest.approx([0.1, 0.2, 0.0])
    assert table[:, 4] == pytest.approx([1.0, 1.0, 2.0])
