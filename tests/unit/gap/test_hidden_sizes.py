"""How much of an effect hides in what a twin is known not to explain."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import pytest

from pytest_dvp.gap.diagnose import hidden_sizes as module
from pytest_dvp.gap.diagnose.diagnosis import Diagnosis, HiddenSize, Step
from pytest_dvp.gap.diagnose.hidden_sizes import hidden_sizes
from pytest_dvp.gap.words.diagnosis import standing_lines
from tests.unit.gap.linear_world import MODEL, tried
from vehicle.model.remainder_shape import RemainderShape


def found(imitates: dict[str, dict[str, float]], *names: str) -> tuple[HiddenSize, ...]:
    model = dataclasses.replace(MODEL, remainder_shape=RemainderShape(imitates=imitates))
    return hidden_sizes(model, tried(*names), ())


def test_what_hides_is_four_times_and_a_bit_what_the_remainder_imitates(monkeypatch: pytest.MonkeyPatch) -> None:
    """With one drive a name asks for 4.3 times as much. Of the range of a brake's gain (0.6 to 1.2) 0.043 is less than
    0.086 of that of a mass (0.7 to 1.4)."""
    sizes = found({"mass": {"ratio": 0.02}, "brake_gain": {"g": 0.01}}, "brake_gain", "mass")
    assert [(one.effect, one.key, one.unit) for one in sizes] == [("mass", "ratio", "-"), ("brake_gain", "g", "-")]
    assert [one.size for one in sizes] == pytest.approx([0.086, 0.043])
    monkeypatch.setattr(module, "times_beyond", lambda judges: 2.0)
    assert found({"mass": {"ratio": 0.02}}, "mass")[0].size == pytest.approx(0.04)


def test_no_size_is_larger_than_the_equation_allows() -> None:
    """Of a share between none and all 1."""
    (share,) = found({"front_wheel_speed": {"share": 0.4}}, "front_wheel_speed")
    assert share.size == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("imitates", "name"),
    [
        ({}, "mass"),  # a model without a known remainder hides nothing
        ({"mass": {"ratio": 0.0046}}, "mass"),  # less than is worth a name, 0.02
        ({"body_pitch": {"gain": 0.1}}, "body_pitch"),  # a finer form of a pitch
        ({"road_profile": {"height": 1.0}}, "road_profile"),  # a hill somewhere
        ({"mass": {"ratio": 0.1}}, "drive_gain"),  # of another effect
    ],
)
def test_of_what_no_size_is_told(imitates: dict[str, dict[str, float]], name: str) -> None:
    assert found(imitates, name) == ()


def lines(not_excited: tuple[str, ...], *hidden: HiddenSize) -> list[str]:
    steps = (Step("", 1.0, {"v": 1.0}, {"v": 0.1}, 1.0),)
    diagnosis = Diagnosis("NOTHING_MISSING", (), not_excited, steps, {"v": 0.05}, {})
    return standing_lines(dataclasses.replace(diagnosis, remainder={"v": {"cruise": 0.1}}, may_hide=hidden))[1:]


def test_a_line_tells_the_first_key_of_each_effect_that_the_drive_could_show() -> None:
    hidden = [HiddenSize("drive_lag", "tau", 0.2, "s"), HiddenSize("creep", "a", 0.5, "m/s^2"),
              HiddenSize("drive_lag", "brakes", 0.3, "-"), HiddenSize("mass", "ratio", 0.0861, "-")]  # fmt: skip
    assert lines(("creep",), *hidden) == [
        "it may hide differences between car and twin of this size, or larger: drive_lag.tau 0.200 s, "
        "mass.ratio 0.0861",
    ]
    assert lines(("mass",), hidden[-1]) == []


def test_eight_effects_are_told() -> None:
    (first, *more) = lines((), *(HiddenSize(f"e{k}", "g", 1.0, "-") for k in range(9)))
    text = " ".join([first, *(line.strip() for line in more)])
    assert text.endswith("e7.g 1.00")


def test_the_document_holds_every_size() -> None:
    steps: Any = (SimpleNamespace(rmse={}, held_out_rmse={}, chi2_per_n=1.0, held_out_chi2_per_n=None,
                                  held_out_setups=(), as_dict=dict),)  # fmt: skip
    one = HiddenSize("drive_lag", "tau", 0.2, "s")
    document = Diagnosis("NOTHING_MISSING", (), (), steps, {}, {}, may_hide=(one,)).as_dict()
    assert document["may_hide"] == [{"effect": "drive_lag", "key": "tau", "size": 0.2, "unit": "s"}]
