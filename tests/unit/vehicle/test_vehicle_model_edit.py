"""A model file that is changed keeps what its user wrote."""

from __future__ import annotations

import dataclasses

import pytest

from vehicle.model.model_file import parse_model
from vehicle.model.model_file_edit import edited_text
from vehicle.model.vehicle_model import AppliedEffect, Interval, VehicleModel

FILE = """\
# My car, weighed on Tuesday.
[parameters]        # before anything else
mass = 800.0        # kg, with driver
wheelbase = 2.36

# what the brakes do
[[effect]]
name = "brake_lag"
[effect.parameters.tau]
value = 0.1         # s, from the data sheet
unit = "s"

# the wind
[[effect]]
name = "aero_drag"
parameters = { k = 0.0006 }  # in one line

[inputs]            # at the end
steer = "steer_cmd"
"""


def fitted(name: str, **values: tuple[float, float, float]) -> AppliedEffect:
    """An effect with values and intervals (value, low, high)."""
    model = parse_model(FILE).with_effect(name, {key: value for key, (value, _, _) in values.items()})
    effect = next(applied for applied in model.effects if applied.name == name)
    intervals = {key: Interval(low, high) for key, (_, low, high) in values.items()}
    return AppliedEffect(effect.effect, effect.values, intervals, ("drive.csv",))


def changed(**more: object) -> VehicleModel:
    return dataclasses.replace(parse_model(FILE), **more)  # type: ignore[arg-type]


def comments(text: str) -> list[str]:
    return [line.partition("# ")[2] for line in text.splitlines() if "# " in line]


def test_a_model_that_is_the_same_is_the_same_text() -> None:
    assert edited_text(FILE, parse_model(FILE)) == FILE


def test_an_effect_is_added_below_and_nothing_else_is_touched() -> None:
    model = changed(effects=(*parse_model(FILE).effects, fitted("steer_delay", T=(0.2, 0.19, 0.21))))
    text = edited_text(FILE, model)
    assert text is not None
    assert text.startswith(FILE.rstrip() + '\n\n[[effect]]\nname = "steer_delay"\nfitted_on = ["drive.csv"]\n')
    assert parse_model(text) == model


def test_an_effect_is_taken_out_with_its_own_comment_only() -> None:
    model = parse_model(FILE).without_effect("brake_lag")
    text = edited_text(FILE, model)
    first, last = FILE.index("# what the brakes"), FILE.index("# the wind")
    assert text == FILE[:first] + FILE[last:]


def test_the_last_effect_is_taken_out_with_the_comments_below_it() -> None:
    """No head comes that they could be about."""
    car = "[parameters]\nmass = 800.0\nwheelbase = 2.36\n\n"
    last = '# the brakes\n[[effect]]\nname = "brake_lag"\nparameters = { tau = 0.1 }\n# from the data sheet\n'
    assert edited_text(car + last, parse_model(car)) == car


def test_a_comment_beside_a_number_that_changed_says_which_number_it_is_about() -> None:
    text = edited_text(FILE, parse_model(FILE).with_car({"mass": 850.0}))
    assert text is not None
    assert [line.split() for line in text.splitlines() if line.startswith("mass")] == [
        ["mass", "=", "850.0", "#", "kg,", "with", "driver;", "was", "800.0"]
    ]
    kept = [line for line in FILE.splitlines() if not line.startswith("mass")]
    assert [line for line in text.splitlines() if line in kept] == kept


@pytest.mark.parametrize("name", ["brake_lag", "aero_drag"])
def test_a_value_that_was_fitted_again_stands_in_its_place(name: str) -> None:
    """As a table and as a number in one line."""
    key, value = ("tau", 0.15) if name == "brake_lag" else ("k", 0.0007)
    again = fitted(name, **{key: (value, 0.9 * value, 1.1 * value)})
    model = changed(effects=tuple(again if a.name == name else a for a in parse_model(FILE).effects))
    text = edited_text(FILE, model)
    assert text is not None
    assert parse_model(text) == model
    assert comments(text) == [
        "s, from the data sheet; was 0.1" if one == "s, from the data sheet" and name == "brake_lag" else one
        for one in comments(FILE)
    ]


def test_a_scale_of_the_inputs_is_added_where_they_stand() -> None:
    given = parse_model(FILE)
    text = edited_text(FILE, changed(inputs=dataclasses.replace(given.inputs, full_throttle=2.5)))
    assert text is not None
    assert text == FILE + "full_throttle = 2.5\n"


def test_a_file_that_cannot_be_changed_so_is_no_text() -> None:
    """An array of tables in one line cannot be added to below."""
    file = (
        'effect = [{ name = "brake_lag", parameters = { tau = 0.1 } }]\n[parameters]\nwheelbase = 2.36\nmass = 800.0\n'
    )
    model = parse_model(file)
    assert edited_text(file, model) == file
    assert edited_text(file, model.with_effect("steer_delay", {"T": 0.2})) is None
