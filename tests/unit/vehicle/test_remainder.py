"""The table [remainder] of a model file: read, written, edited, and refused where it is wrong."""

from __future__ import annotations

import dataclasses

import pytest

from pytest_dvp.gap.compare.regimes import REGIMES
from pytest_dvp.gap.compare.segments import CHANNELS, UNITS
from vehicle.model.errors import ModelError
from vehicle.model.model_file import model_text, parse_model
from vehicle.model.model_file_edit import edited_text
from vehicle.model.remainder import CHANNEL_UNITS, REGIME_NAMES
from vehicle.model.remainder_shape import STEEPEST

CAR = '[parameters]\nwheelbase = 2.5\n\n[[effect]]\nname = "steer_delay"\nparameters.T = 0.1\n'
SHAPE = "[remainder.memory]\nyaw_rate = 0.16\n[remainder.imitates]\ndrive_gain.g = 0.005\nsteer_assist.g = 0.1\n"
LEFT = "[remainder]\nyaw_rate.turn_in = 0.012\nax.braking = 0.21\n"


def test_it_is_read_and_written_back() -> None:
    model = parse_model(CAR + LEFT)
    assert model.remainder == {"yaw_rate": {"turn_in": 0.012}, "ax": {"braking": 0.21}}
    assert parse_model(model_text(model)) == model


def test_its_shape_is_read_and_written_back() -> None:
    model = parse_model(CAR + LEFT + SHAPE)
    assert model.remainder_shape.memory == {"yaw_rate": 0.16}
    assert model.remainder_shape.imitates == {"drive_gain": {"g": 0.005}, "steer_assist": {"g": 0.1}}
    assert parse_model(model_text(model)) == model
    edited = edited_text(CAR + LEFT + SHAPE, dataclasses.replace(model, remainder={"v": {"launch": 0.05}}))
    assert edited is not None
    assert (edited.count("[remainder.memory]"), edited.count("[remainder.imitates]")) == (1, 1)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("memory.yawrate = 0.1", r"remainder\.memory\.yawrate: unknown channel .* did you mean 'yaw_rate'"),
        ("memory.yaw_rate = 0.0", r"remainder\.memory\.yaw_rate: value not allowed \(found 0; allowed: more than 0 s"),
        ("memory = 1", r"remainder\.memory: must be a table"),
        ("imitates.drive_gain = 1", r"remainder\.imitates\.drive_gain: must be a table of the effect's keys"),
        ("imitates.drive_gain.g = -1", r"remainder\.imitates\.drive_gain\.g: value not allowed"),
        ("imitates.drive_gain.g = 'x'", r"remainder\.imitates\.drive_gain\.g: must be a number"),
    ],
)
def test_what_is_wrong_in_its_shape_is_one_line(text: str, says: str) -> None:
    with pytest.raises(ModelError, match=says):
        parse_model(f"{CAR}[remainder]\n{text}\n", "m.toml")


def test_a_file_keeps_its_comments_when_only_the_remainder_changes() -> None:
    before = f"# my car\n{CAR}"
    model = dataclasses.replace(parse_model(before), remainder={"v": {"launch": 0.05}})
    first = edited_text(before, model)
    assert first is not None
    assert first.startswith("# my car\n")
    assert parse_model(first) == model
    second = edited_text(first, dataclasses.replace(model, remainder={"v": {"launch": 0.07}}))
    assert second is not None
    assert (second.count("[remainder]"), second.count("known not to explain")) == (1, 1)
    without = edited_text(second, parse_model(before))
    assert without is not None
    assert "remainder" not in without
    assert "known not to explain" not in without


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("[remainder]\nv.cruise = 1.0\nmemory.vv = 3.0", 3),
        ("[remainder]\nv.cruise = 1.0\n[remainder.wanders]\nalong.cruise = 0.1\nalong.cruse = 0.1", 5),
        ("[remainder]\nv.cruise = 1.0\n[remainder.limits.jerk_limit]\nlimit = -3.0", 4),
        ("[remainder]\nv.cruise = 1.0\nwanders = 3", 3),
    ],
)
def test_the_line_is_that_of_the_key_however_the_table_is_written(text: str, line: int) -> None:
    with pytest.raises(ModelError) as refused:
        parse_model(f"{CAR}{text}\n", "m.toml")
    assert refused.value.line == CAR.count("\n") + line


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("yawrate.braking = 0.1", r"m\.toml:\d+: remainder\.yawrate: unknown channel .* did you mean 'yaw_rate'"),
        ("ax.brakes = 0.1", r"remainder\.ax\.brakes: unknown driving regime .* did you mean 'braking'"),
        ("ax.braking = -1", r"remainder\.ax\.braking: value not allowed \(found -1; allowed: 0 m/s\^2 or more"),
        ("ax.braking = 'much'", r"remainder\.ax\.braking: must be a number"),
        ("ax = 0.1", r"remainder\.ax: must be a table of driving regimes"),
    ],
)
def test_what_is_wrong_is_one_line_with_its_place(text: str, says: str) -> None:
    with pytest.raises(ModelError, match=says):
        parse_model(f"{CAR}[remainder]\n{text}\n", "m.toml")


def test_the_names_are_those_of_a_comparison() -> None:
    assert dict(CHANNEL_UNITS) == dict(UNITS)
    assert tuple(CHANNEL_UNITS) == CHANNELS
    assert REGIME_NAMES == REGIMES


def test_a_misspelt_table_is_told_with_the_nearest_name() -> None:
    text = f"{CAR}[remainder]\nv.cruise = 1.0\n[remainder.roads]\nslopes = 0.06\n"
    with pytest.raises(ModelError, match=r"unknown channel or table \(found roads; .*road\); did you mean 'road'"):
        parse_model(text, "m.toml")


def test_what_is_just_allowed_and_just_not() -> None:
    """Nothing may be left of a channel; a limit of nought would forbid every motion. A slope may be as steep as
    5 m/s^2, and an effect of somebody's own may have a name that only begins like one of ours."""
    head = f"{CAR}[remainder]\n"
    assert parse_model(f"{head}ax.braking = 0\n").remainder == {"ax": {"braking": 0.0}}
    shape = parse_model(
        f"{head}road.slopes = {STEEPEST}\nimitates.brake_lag2.tau = 0.0\nlimits.jerk_limit.limit = 0.1\n"
    ).remainder_shape
    assert (shape.slopes, shape.imitates) == (STEEPEST, {"brake_lag2": {"tau": 0.0}})
    assert shape.limits == {"jerk_limit": {"limit": 0.1}}
    for wrong, says in (
        (f"road.slopes = {STEEPEST + 0.01}", "road.slopes: value not allowed"),
        ("limits.jerk_limit.limit = 0", "found 0; allowed: more than 0"),
        ("imitates.brke_lag.tau = 1", "unknown effect"),
        ("unseen.jerk_limit.limit = 0", "found 0; allowed: more than 0"),
    ):  # fmt: skip
        with pytest.raises(ModelError, match=says):
            parse_model(f"{head}{wrong}\n")
