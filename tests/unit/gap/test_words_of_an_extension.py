"""What an extension says in a terminal: what was added, the error after each step, and whether to go on."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from pytest_dvp.gap.diagnose.diagnosis import Estimate, NamedEffect
from pytest_dvp.gap.words.diagnosis import figure, three
from pytest_dvp.gap.words.extension import ladder, page, rest

MASS = {"ratio": Estimate(1.25, 1.2, 1.3, "-")}
DELAY = {"T": Estimate(0.1, 0.08, 0.12, "s")}


def a_step(left: float, held: float | None = None, **more: Any) -> Any:
    found = {"chi2_per_n": left, "held_out_chi2_per_n": held, "rmse": {"v": 0.5}, "held_out_rmse": {"v": 0.25},
             "channels": {"v": left}} | more  # fmt: skip
    return SimpleNamespace(**found)


def an_extension(*steps: Any, **more: Any) -> Any:
    rungs = tuple(SimpleNamespace(change="" if k == 0 else f"change {k}", step=step) for k, step in enumerate(steps))
    found = {"ladder": rungs, "effects": (), "refitted": {}, "noise_floor": {"v": 0.01}, "notes": (), "refusal": "",
             "explained": False, "excused": False, "model": SimpleNamespace(remainder={})} | more  # fmt: skip
    return SimpleNamespace(**found)


@pytest.mark.parametrize(
    ("number", "told"),
    [(None, "-"), (0.0, "0.00"), (1.006, "1.01"), (9.994, "9.99"), (9.996, "10.0"), (99.94, "99.9"), (99.96, "100"),
     (12345.6, "12346")],
)  # fmt: skip
def test_a_figure_has_two_decimals_below_ten_and_one_below_a_hundred(number: float | None, told: str) -> None:
    assert figure(number) == told


@pytest.mark.parametrize(("number", "told"), [(0.5, "0.500"), (12.0, "12.0"), (123.4, "123"), (0.012345, "0.0123")])
def test_three_figures_are_shown_zeros_too(number: float, told: str) -> None:
    assert three(number) == told


def test_the_ladder_has_a_row_a_step_fitted_then_held_out_and_the_noise() -> None:
    rungs = an_extension(a_step(12.0, 8.0), a_step(1.5, 2.0, rmse={"v": 0.1}, held_out_rmse={})).ladder
    rows = [line.split() for line in ladder(rungs, {"v": 0.01})]
    assert rows == [
        ["error", "(RMSE)", "chi²/N", "v", "[m/s]"],
        ["fit", "model", "as", "given", "12.0", "0.500"],
        ["fit", "change", "1", "1.50", "0.100"],
        ["held", "out", "model", "as", "given", "8.00", "0.250"],
        ["held", "out", "change", "1", "2.00", "-"],
        ["noise", "1", "0.0100"],
    ]
    alone = an_extension(a_step(12.0), a_step(1.5)).ladder
    assert [line.split()[0] for line in ladder(alone, {})] == ["error", "fit", "fit", "noise"]


@pytest.mark.parametrize(
    ("left", "held", "elsewhere"),
    [(2.0, 2.3, True), (2.0, 2.2, False), (2.0, None, False), (1.0, 1.3, False), (1.0, 1.31, True), (2.0, 1.0, False)],
)
def test_what_is_missing_shows_on_held_out_data_if_they_are_left_with_a_tenth_more(
    left: float, held: float | None, elsewhere: bool
) -> None:
    """And with more than 1.3 of chi^2/N, up to which what is left counts as noise."""
    told = rest(an_extension(a_step(9.0), a_step(left, held)))
    assert told.startswith(f"more is missing: chi²/N {left:.2f}")
    assert ("on held-out data" in told) is elsewhere
    assert (f"where it was fitted, {held:.2f} on" in told) is elsewhere if held is not None else True


def test_what_is_missing_is_told_by_the_signal_that_has_most_of_it() -> None:
    told = rest(an_extension(a_step(2.0, channels={"v": 1.0, "yaw": 5.25, "x": 3.0})))
    assert "most in yaw (5.25)" in told


@pytest.mark.parametrize(
    ("excused", "noise"), [(True, "what the twin is known to leave"), (False, "the sensors' noise")]
)
def test_where_nothing_is_left_it_says_stop(excused: bool, noise: str) -> None:
    told = rest(an_extension(a_step(1.05), explained=True, excused=excused))
    assert told == (f"over the whole drive what is left is no more than {noise} (chi²/N 1.05): stop here, more effects "
                    "would fit noise")  # fmt: skip


def test_each_effect_has_its_sign_its_values_and_its_share() -> None:
    effects = (
        NamedEffect("mass", MASS, gain=0.75, rivals=("drive_gain", "brake_gain")),
        NamedEffect("steer_delay", DELAY, gain=0.25, action="change"),
        NamedEffect("aero_drag", {}, action="remove"),
        NamedEffect("creep", {}),
    )
    seen = NamedEffect("detection_latency", DELAY, gain=0.5)
    refitted = {("body_roll", "gain"): Estimate(0.05, 0.04, 0.06, "rad s^2/m")}
    lines = page(an_extension(a_step(2.0), effects=(*effects[:1], seen, *effects[1:]), refitted=refitted)).split("\n")
    assert lines[0].startswith("  + mass: ratio = 1.2")
    assert lines[0].endswith("explains 75 % of the error; drive_gain, brake_gain would do as well")
    assert lines[1] == "  ~ steer_delay: T = 0.10 s (0.08 to 0.12), explains 25 % of the error"
    assert lines[2:4] == ["  - aero_drag", "  + creep: these data give it no value"]
    assert lines[4] == "  + detection_latency: T = 0.10 s (0.08 to 0.12), explains 50 % of what the detections show"
    assert lines[5].startswith("  ~ body_roll.gain: 0.05 rad s^2/m (0.04")
    assert lines[6] == ""


def test_notes_gates_and_what_is_known_to_be_left_follow_unless_it_was_refused() -> None:
    known = SimpleNamespace(remainder={"v": {"cruise": 0.05, "hard_braking": 0.25}})
    given: dict[str, Any] = {"notes": ("first", "second"), "model": known}
    lines = page(an_extension(a_step(2.0), **given), ["gate a", "gate b"]).split("\n")
    assert [lines.index(text) for text in ("gate a", "gate b", "note: first", "note: second")] == [5, 6, 8, 9]
    assert lines[11].startswith("more is missing")
    assert lines[12] == ("written as [remainder], what the new model does not explain in single driving regimes: "
                         "v up to 0.250 m/s (hard braking)")  # fmt: skip
    refused = page(an_extension(a_step(2.0), refusal="why", **given)).split("\n")
    assert refused[-1] == "note: second"
    bare = page(an_extension(a_step(2.0))).split("\n")
    assert bare[-2] == ""
    assert bare[-1].startswith("more is missing")
