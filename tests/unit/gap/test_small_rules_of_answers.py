"""Small rules by which an answer is judged and told, each of which one number or one word decides."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from gap_logs import baseline, drive

from pytest_dvp.gap.compare import noise_floor
from pytest_dvp.gap.compare.regimes import regimes
from pytest_dvp.gap.compare.segments import cut
from pytest_dvp.gap.diagnose import rivals
from pytest_dvp.gap.diagnose.diagnosis import Estimate, NamedEffect
from pytest_dvp.gap.diagnose.experiment import Experiment
from pytest_dvp.gap.diagnose.held_out import step
from pytest_dvp.gap.diagnose.known_remainder import expected
from pytest_dvp.gap.diagnose.lasting_remainder import _fallen
from pytest_dvp.gap.diagnose.veto import Judged
from pytest_dvp.gap.discover.scan import Scan
from pytest_dvp.gap.discover.term import POINTS, Form, Term
from pytest_dvp.gap.extend import perception
from pytest_dvp.gap.extend.settled_fit import settled_fit
from pytest_dvp.gap.manoeuvres import discrimination
from pytest_dvp.gap.perception.perceived_values import Perceived
from pytest_dvp.gap.words.diagnosis_page import _close
from tests.unit.gap.linear_world import BRAKE, DRIVE, World, a_search, a_trial, direction
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.model_file import parse_model


def test_half_as_much_again_as_the_known_remainder_is_nothing_new() -> None:
    """In squares, beside the noise of the log itself."""
    log = drive(20.0)
    told = {"v": {"launch": 0.3, "cruise": 0.2}}
    one = Experiment("one", log, dataclasses.replace(baseline(), remainder=told))
    left = expected(told, log, one.measured)
    assert left[3] > 0.15
    assert one.sigma == pytest.approx(np.sqrt(one.noise**2 + (1.5 * left) ** 2), nan_ok=True)


def test_who_cruises_drives_forward_and_neither_starts_nor_brakes_nor_has_let_go() -> None:
    """64 Hz: 10 s at rest, a launch, demand until 30 s, then none, a braking, at last backwards."""
    t = np.arange(0.0, 80.0, 1.0 / 64.0)
    v = np.where(t < 10.0, 0.0, np.where(t < 70.0, 20.0, -5.0))
    demand = np.where((t > 20.0) & (t < 30.0), 2.0, np.where((t > 50.0) & (t < 55.0), -2.0, 0.0))
    masks = regimes(t, v, np.zeros(len(t)), demand)
    others = masks["standstill"] | masks["launch"] | masks["braking"] | masks["lift_off"] | masks["reverse"]
    for name in ("standstill", "launch", "braking", "lift_off", "reverse"):
        assert masks[name].any(), name
    assert masks["cruise"].tolist() == (~others).tolist()


def test_a_rival_is_what_came_last_into_the_set_in_the_place_of_another() -> None:
    """Beside what stays: the brake's gain stays, the mass comes for the drive's gain."""
    best, other = a_trial(100.0, "brake_gain", "drive_gain"), a_trial(100.0, "brake_gain", "mass")
    search: Any = SimpleNamespace(
        without=lambda trial, name: a_trial(900.0, *(n for n in trial.names if n != name)),
        in_place_of=lambda trial, name: [other] if name == "drive_gain" else [],
        is_rival=lambda *asked: True, is_credible=lambda *asked: True, bootstrap_share=lambda *asked: 0.5,
    )  # fmt: skip
    assert rivals.rivals_over_segments(search, (), best) == {"brake_gain": (), "drive_gain": ("mass",)}


def test_a_step_adds_the_last_effect_of_its_set_alone() -> None:
    world = World({DRIVE: 100.0 * direction(0), BRAKE: 100.0 * direction(1)}, {DRIVE: 0.9, BRAKE: 0.9})
    search = a_search(world, "drive_gain", "brake_gain")
    trial = search.trial(("drive_gain", "brake_gain"), {DRIVE: 0.9, BRAKE: 0.9})
    assert step(search, trial, ()).added == "brake_gain"
    assert step(search, search.trial((), {}), ()).added == ""


def test_held_out_data_took_no_part_in_a_choice_unless_it_is_said() -> None:
    found: Any = None
    assert not Judged(found, (), {}, ()).chose


@pytest.mark.parametrize(("gains", "rounds"), [((0.0,), 1), ((1.0, 0.1), 2), ((1.0,) * 9, 5)])
def test_a_fit_is_repeated_while_it_gains_a_five_thousandth_of_a_sample_s_noise(gains: Any, rounds: int) -> None:
    """Of 1000 samples 0.2; five times at most, and once more at the end."""
    left = iter(900.0 - np.cumsum(gains))
    fitted: list[float] = []

    def trial(names: Any, values: Any, zoom: bool) -> Any:
        fitted.append(next(left, 0.0))
        return SimpleNamespace(names=names, values=values, chi2=fitted[-1])

    search: Any = SimpleNamespace(count=1000, trial=trial, target=SimpleNamespace(settle=lambda values: None))
    settled_fit(search, SimpleNamespace(names=(), values={}, chi2=900.0))  # type: ignore[arg-type]
    assert len(fitted) == rounds + 1


@pytest.mark.parametrize(("told", "good"), [((0.29, 0.1, 0.35), True), ((0.1, 0.29, 0.35), False)])
def test_what_held_out_data_tell_is_their_value_not_an_end_of_its_interval(
    monkeypatch: pytest.MonkeyPatch, told: tuple[float, float, float], good: bool
) -> None:
    seen = Perceived({("detection_latency", "T"): told}, {}, {})
    monkeypatch.setattr(perception, "_seen_in", lambda log, model, twins: seen)
    found = NamedEffect("detection_latency", {"T": Estimate(0.3, 0.28, 0.32, "s")})
    model = parse_model("[parameters]\nwheelbase = 2.5\n")
    held: Any = {"a": None}
    judged = perception._added(find_effect("detection_latency"), found, model, held, {})
    assert (judged.wrong == "") is good
    if not good:
        assert "T is 0.1 s there, 0.3 where it was fitted" in judged.wrong


@pytest.mark.parametrize("size", [100.0, 1.0, 0.01])
def test_how_alike_two_terms_are_does_not_hang_on_their_size(size: float) -> None:
    """(3, 4) and (4, 3): 24 / 25; nothing is like what shows nowhere."""
    scan = Scan.__new__(Scan)
    scan.columns = size * np.array([[3.0, 4.0], [-4.0, -3.0], [0.0, 0.0]], dtype=np.float32)
    assert scan.likeness(0, 1) == pytest.approx(0.96)
    assert scan.likeness(0, 2) == 0.0


@pytest.mark.parametrize("gate", [(), ("a-",), ("a-", "v")])
def test_a_term_has_nothing_in_the_places_that_its_form_leaves_open(gate: tuple[str, ...]) -> None:
    values = Term(POINTS[0], Form(gate)).values("e")
    assert [values["e", f"g{k}"] for k in range(len(gate) + 1, 4)] == [0.0] * (3 - len(gate))
    assert (values["e", "h1"], values["e", "h2"]) == (0.0, 0.0)


def test_a_correlation_of_a_single_pair_counts_as_that_of_many() -> None:
    """Of 0.5, 1, 1 neighbours have 0.75 in the mean, the one pair two apart 0.5: more than a third of that."""
    assert _fallen(np.array([0.5, 1.0, 1.0]), np.array([0])) == 3
    assert _fallen(np.array([0.2, 1.0, 1.0]), np.array([0])) == 2


def test_an_error_to_either_side_counts_by_its_square() -> None:
    """4 rows of -3 in the first segment, of 2 in the second, all of it taken away: 36 and 16."""
    before, after = np.zeros((8, 8)), np.zeros((8, 8))
    before[:, 3] = [-3.0] * 4 + [2.0] * 4
    one: Any = SimpleNamespace(
        channels=("v",), sigma=np.full(8, 0.5), measured=np.zeros((8, 8)), log=SimpleNamespace(t=np.arange(8.0)),
        segments=SimpleNamespace(starts=np.array([0, 4]), ends=np.array([4, 8])),
    )  # fmt: skip
    drawn: Any = SimpleNamespace(name="a.csv", held_out=False, experiment=one, before=before, after=after)
    close = _close([drawn], ["v"])
    assert close is not None
    assert close["t"].tolist() == [1.0, 2.0, 3.0]
    assert close["before"].tolist() == [3.0, 3.0, 3.0]


def test_about_town_it_is_driven_with_the_first_effect_whatever_the_others_have(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with_values: list[Any] = []
    monkeypatch.setattr(discrimination, "typical", lambda coordinates, points: {("a", "k"): 2.0})
    monkeypatch.setattr(discrimination, "closest_values", lambda town, candidate: {("c", "k"): 0.5})

    def rehearse(drive: Any, values: Any) -> str:
        with_values.append(values)
        return "town"

    asked: Any = SimpleNamespace(model=None, shared={}, envelope=None, rehearse=rehearse, perform=lambda *a: "drive")
    wanted: Any = [SimpleNamespace(name=name, coordinates=(), points=()) for name in "abc"]
    discrimination._complete(asked, wanted, {"a": {}, "b": {("b", "k"): 9.0}, "c": {}})
    assert with_values == [{("a", "k"): 2.0}]


@pytest.mark.parametrize("every", [1, 2])
def test_a_slide_shows_at_whatever_rate_the_place_is_measured(every: int) -> None:
    """20 s at 5 m/s: ahead along x, but from 8 s to 12 s along y without turning, straight to the side."""
    t = np.arange(0.0, 20.0, 0.05)
    aside = (t > 8.0) & (t < 12.0)
    measured = np.full((len(t), 8), np.nan)
    place = np.cumsum(np.column_stack([~aside, aside]) * 5.0 * 0.05, axis=0)
    measured[::every, :2], measured[::every, 2] = place[::every], 0.0
    measured[:, 3], measured[:, 4] = 5.0, 0.0
    slides = cut(t, measured).slides
    assert slides[(t > 8.5) & (t < 11.5)].all()
    assert not slides[(t < 7.0) | (t > 13.0)].any()


def test_a_filtered_signal_shorter_than_a_second_has_the_floor_of_as_much_of_a_line_as_fits_in() -> None:
    """16 samples with a corner in the middle, at which the slope grows by 2: over two times 7 samples it leaves a line
    by 12 and 14, between the 1st and 99th percentiles of which lie 1.96, of which 0.5 % are far above noise of 1e-4."""
    i = np.arange(16.0)
    y = np.abs(i - 8.0) + 0.137 * i + 0.0171 * i * i + 1e-4 * np.random.default_rng(0).normal(size=16)
    assert noise_floor.sigma(0.02 * i, y, filtered=True) == pytest.approx(0.005 * 1.96, rel=1e-3)
