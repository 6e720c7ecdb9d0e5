"""`dvp iterate` of a car and a stack of one's own: nothing of the paper's car is set in the twin or in the stack."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from pytest_dvp.tuning.iterate import beginning
from pytest_dvp.tuning.iteration_plan import STAGES, Plan, drives
from pytest_dvp.tuning.iteration_plan_file import read_plan
from pytest_dvp.tuning.iteration_text import headline, table
from pytest_dvp.tuning.result_bounds import Bound
from pytest_dvp.workers.errors import TuneError
from vehicle.model.model_file import read_model

CAR = """
[model]
name = "mine"
base = "kinematic_bicycle"

[inputs]
longitudinal = "accel_cmd"
steer = "steer_cmd"

[parameters]
wheelbase = 2.7
mass = 1450.0

[[effect]]
name = "steer_delay"
[effect.parameters]
T = 0.08
"""
STACK = """
class Keeper:
    parameters = {"LK_throttle": 0.25, "LK_ticks": 10}
"""
PLAN = """[iterate]
model = "car.toml"
ads = "mine.py:Keeper"

[[scenario]]
file = "follow.xosc"

[[held_out]]
file = "follow.xosc"
set = { ego_speed = 5.0 }

[parameters]
"P.LK_throttle" = [0, 0.5]
"S.EGO_mass" = [1300, 1600]
"S.GNSS_x" = [-0.5, 0.5]

[[term]]
metric = "completion_time"
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "car.toml").write_text(CAR)
    (tmp_path / "mine.py").write_text(STACK)
    return tmp_path


def planned(folder: Path, old: str = "", new: str = "") -> Plan:
    assert old in PLAN
    (folder / "plan.toml").write_text(PLAN.replace(old, new) if old else PLAN)
    return read_plan(folder / "plan.toml")


def test_without_a_preset_the_twin_is_what_its_file_says(folder: Path) -> None:
    state = beginning(planned(folder), folder / "out")
    twin = read_model(state.model)
    assert twin.car.mass == 1450.0
    assert {a.name: dict(a.values) for a in twin.effects} == {"steer_delay": {"T": 0.08}}


def test_a_preset_that_is_stated_is_set_in_it(folder: Path) -> None:
    plan = planned(folder, "[iterate]", "[iterate]\npreset = 1")
    assert read_model(beginning(plan, folder / "out").model).car.mass == 1000.0  # Arango et al., 1st iteration


def test_a_candidate_of_s_begins_at_the_twin_and_p_at_what_the_stack_declares(folder: Path) -> None:
    plan = planned(folder)
    (throttle,) = plan.P
    mass, _ = plan.S
    assert throttle.values == (0.0, 0.25, 0.5)
    assert mass.values == (1300.0, 1450.0, 1600.0)
    found = beginning(plan, folder / "out").P
    assert set(found) == set(STAGES)
    assert all(values == {"LK_throttle": 0.25, "LK_ticks": 10.0} for values in found.values())


def test_every_drive_is_of_that_stack(folder: Path) -> None:
    plan = planned(folder)
    state = beginning(plan, folder / "out")
    for drive in drives(plan, state, plan.variants, plan.seeds, folder / "logs"):
        assert str(drive.job.ads).endswith("mine.py:Keeper")
        assert dict(drive.job.P) == {"LK_throttle": 0.25, "LK_ticks": 10.0}


def test_performance_is_what_the_plan_says(folder: Path) -> None:
    assert [term.metric for term in planned(folder).performance.terms] == ["completion_time"]


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('"P.LK_throttle"', '"P.LK_throtle"', r"plan.toml:13: .*'LK_throtle', did you mean 'LK_throttle'\?"),
        ("mine.py:Keeper", "mine.py:Keper", r"plan.toml:3: .*unknown class 'Keper', did you mean 'Keeper'\?"),
        ("[0, 0.5]", '"much"', r"plan.toml:13: P.LK_throttle is 'much', expected \[values\] or \{ values = "),
        ('"completion_time"', '"completion_tim"', r"plan.toml:18: .*did you mean 'completion_time'\?"),
        ("[iterate]", "[iterate]\niterations = 0", r"plan.toml:2: iterations is 0, expected a whole number >= 1"),
        ("[iterate]", "[iterate]\nlast_seeds = [5]", r"plan.toml:2: last_seeds is \[5\], expected two at least"),
        ("[iterate]", "[iterate]\nlast_seeds = [5, 101]", r"plan.toml:2: last_seeds and held_out_seeds share 101: "),
    ],
)
@pytest.mark.nightly(by_day=3)
def test_a_slip_is_one_line_with_its_place(folder: Path, old: str, new: str, says: str) -> None:
    with pytest.raises(TuneError, match=says) as refused:
        planned(folder, old, new)
    assert "\n" not in str(refused.value)


def test_what_could_not_be_measured_is_no_miss() -> None:
    rows = [Bound("MNCC object x", "dt-rw", None, None, None, ">= 0.995", False, "", None)]
    told = table(rows)
    assert told[2] == "none could be measured of: MNCC object x (dt-rw)"
    assert told[-1] == "0 of 1 bounds hold; none: 1 could not be measured"


def test_too_few_repeats_are_no_miss() -> None:
    rows = [Bound("max jerk, between stages", "dt-rw", 0.0, 0.1, 0.1, "within 0.036", False, "", None, 0.036)]
    told = table(rows)
    assert told[2].startswith("open max jerk")
    assert told[-1] == "0 of 1 bounds hold; open: 1 need more repeats (last_seeds)"


def _entry(chi2: float | None, *words: str, accepted: str = "twin and stack") -> dict[str, Any]:
    return {"accepted": accepted, "structure": {"taken": list(words)}, "held_out": {"chi2_per_n": chi2}}


@pytest.mark.parametrize(
    ("entries", "structure", "says"),
    [
        (
            [_entry(35.0, accepted="beginning"), _entry(0.2, "+ drive_gain g = 0.8")],
            True,
            "Twin extended: + drive_gain g = 0.8. It is the car to within the noise of its sensors (chi^2/N of "
            "held-out drives 35 -> 0.2).",
        ),
        (
            [_entry(35.0, accepted="beginning"), _entry(35.0, "+ drive_gain g = 0.8", accepted="")],
            True,
            "No effect was added to the twin. chi^2/N of held-out drives 35 -> 35, where 1 would be the noise of the "
            "sensors.",
        ),
        (
            [_entry(35.0, accepted="beginning"), _entry(10.0)],
            False,
            "No effect was added to the twin. chi^2/N of held-out drives 35 -> 10, where 1 would be the noise of the "
            "sensors; nothing was looked for that it lacks (--tune-only).",
        ),
        ([_entry(None, accepted="beginning")], True, "No effect was added to the twin. chi^2/N of held-out drives -"),
    ],
    ids=["named", "refused", "tuned alone", "not measured"],
)  # fmt: skip
def test_the_headline_tells_a_twin_that_is_right_from_one_that_is_not(
    entries: list[dict[str, Any]], structure: bool, says: str
) -> None:
    assert headline(entries, structure=structure).startswith(says)
