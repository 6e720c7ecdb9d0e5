"""How a manoeuvre is driven with a car that is made up, how a plan is written, and what is advised on given fits."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.manoeuvres import advice, discrimination, plan_folder, rehearsal, simulated_drive
from pytest_dvp.gap.manoeuvres import choice as choosing
from pytest_dvp.gap.manoeuvres.advice import _fitted, _hypotheses, advise, between
from pytest_dvp.gap.manoeuvres.choice import PlanError, RehearsalInputs
from pytest_dvp.gap.manoeuvres.discrimination import Evidence, _Looked, decide
from pytest_dvp.gap.manoeuvres.driving_limits import Area, Envelope
from pytest_dvp.gap.manoeuvres.rehearsal import NOISE, Hypothesis, Rehearsal, closest_values
from pytest_dvp.gap.manoeuvres.simulated_drive import Drive, drive, perform
from pytest_dvp.gap.manoeuvres.simulated_driver import DriverDemand, Motion
from tests.unit.gap.drivers import ENVELOPE, driver
from vehicle.model.model_file import parse_model
from vehicle.sensors.gnss import Gnss
from vehicle.sensors.imu import InertialUnit
from vehicle.sensors.odometry import WheelOdometry

MODEL: Any = parse_model("[model]\nname = 'c'\n[parameters]\nwheelbase = 2.5\n")
CAR: Any = SimpleNamespace(center_x=1.25, length=4.0, wheelbase=2.5)


def a_manoeuvre(steps: int | None = None, **given: Any) -> Any:
    """Asks for as many accelerations, counted up, as there are steps; notes the driver and what it is shown."""
    shown: list[Any] = []

    def drive(d: Any) -> Any:
        shown.append(d)
        k = 0
        while steps is None or k < steps:
            shown.append((yield DriverDemand(float(k), 0.25, 2.0)))
            k += 1

    return SimpleNamespace(drive=drive, round_about=False, shown=shown, name="m", **given)


def answers() -> Any:
    """A car that is at 1, 2, 3 ... m after each period."""
    count = iter(range(1, 100_000))
    return lambda wish: (float(next(count)), wish.accel, 0.5, 4.0, 0.125)


# --- drives


def test_a_row_of_a_drive_is_what_is_asked_for_and_where_the_car_is_then() -> None:
    manoeuvre = a_manoeuvre(3)
    found = drive(manoeuvre, CAR, answers(), ENVELOPE)
    assert found.t.tolist() == [0.0, 0.02, 0.04]
    assert found.wishes.tolist() == [[0.0, 0.25, 2.0], [1.0, 0.25, 2.0], [2.0, 0.25, 2.0]]
    assert found.motion.tolist() == [[0.0] * 5, [1.0, 0.0, 0.5, 4.0, 0.125], [2.0, 1.0, 0.5, 4.0, 0.125]]
    assert manoeuvre.shown[1:] == [Motion(float(k + 1), float(k), 0.5, 4.0) for k in range(3)]
    assert (found.size, found.seconds, found.manoeuvre) == (1.0, 0.04, manoeuvre)


def test_a_car_stands_out_ahead_of_its_rear_axle_by_its_middle_and_half_its_length() -> None:
    """1.25 + 2 m, and one metre that is kept free, beside the turn."""
    manoeuvre = a_manoeuvre(1)
    found = drive(manoeuvre, CAR, answers(), ENVELOPE, 0.5)
    turn = manoeuvre.shown[0].radius + 3.25 + 1.0
    assert found.area.x_min == pytest.approx(-turn)
    assert found.area.x_max - found.area.x_min == pytest.approx(100.0)
    assert found.size == 0.5
    assert manoeuvre.shown[0].push == pytest.approx(0.94 * 0.5 * 2.0)


def test_no_drive_is_longer_than_three_minutes() -> None:
    found = drive(a_manoeuvre(), CAR, answers(), ENVELOPE)
    assert len(found.t) == len(found.wishes) == len(found.motion) == 180 * 50


@pytest.mark.parametrize(("fits", "tried"), [(1.0, 1), (0.86, 2), (0.7, 3), (0.55, 4), (0.5, 4)])
def test_the_largest_size_is_driven_that_keeps_within_the_limits(
    fits: float, tried: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    sizes: list[float] = []

    def made(manoeuvre: Any, car: Any, respond: Any, envelope: Any, size: float) -> Any:
        sizes.append(size)
        return SimpleNamespace(size=size, t=None, motion=None, wishes=np.full((2, 3), size), area=None, finished=True)

    monkeypatch.setattr(simulated_drive, "drive", made)
    monkeypatch.setattr(simulated_drive, "responder", lambda model: None)
    monkeypatch.setattr(
        simulated_drive, "violations", lambda t, motion, steer, *limits: ("much",) if steer[0] > fits else ()
    )
    found = perform(a_manoeuvre(), MODEL, {}, ENVELOPE)
    assert len(sizes) == tried
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[0] == 1.0  # as large as it may be
    assert (found is None) is (fits < 0.55)
    assert found is None or found.size == sizes[-1] <= fits


def test_a_demand_is_rounded_to_what_a_robot_can_do() -> None:
    """A tenth of a millimetre per second squared, ten microradians, a millimetre a second."""
    d = driver()
    d.car = Motion(0.0, 0.0, 0.0, 5.0)
    d._speed, d._steer = 5.0, 0.0
    asked = next(d._tick(0.123456, 0.0123456, 5.0012345))
    assert asked == DriverDemand(0.1235, 0.01235, 5.001)


def still(driving: Any, d: Any, car: Motion, most: int = 10_000) -> int:
    """How often something is asked of a car that does not move."""
    d.car, count = car, 0
    try:
        next(driving)
        count += 1
        while count < most:
            driving.send(car)
            count += 1
    except StopIteration:
        pass
    return count


def test_a_driver_whose_car_does_not_move_gives_up() -> None:
    """A minute to the end of the straight, 20 s in the turn; a minute for a circle, whatever its turns."""
    d = driver()
    assert still(d.turn(), d, Motion(0.0, 0.0, 0.0, 1.0)) == 60 * 50 + 20 * 50
    d = driver(round_about=True)
    assert still(d.close_circle(0.2), d, Motion(0.0, 20.0, 1.0, 1.0)) == 60 * 50
    assert still(d.circle(3.0, 0.2, turns=1.0), d, Motion(0.0, 20.0, 1.0, 1.0)) == 60 * 50


def test_a_turn_is_over_three_tenths_of_a_radian_before_the_other_heading() -> None:
    for missing, ticks in ((0.29, 0), (0.31, 20 * 50)):
        d = driver()
        assert still(d.turn(), d, Motion(500.0, 0.0, math.pi - missing, 1.0)) == ticks


# --- plans


def test_a_plan_goes_into_a_folder_that_may_be_there_and_replaces_what_it_holds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    t = np.array([0.0, 0.02])
    one = Drive(a_manoeuvre(), 1.0, Area(-5.0, 90.0, -8.0, 52.0), t, np.ones((2, 3)), np.zeros((2, 5)))
    choice: Any = SimpleNamespace(
        drive=one, exciting=True, effects=("mass", "drag"), manoeuvre=SimpleNamespace(title="Brake")
    )
    monkeypatch.setattr(plan_folder, "road", lambda area: f"road {area.x_max:g}")
    monkeypatch.setattr(plan_folder, "scenario", lambda drive, car, envelope, road, what: f"{road}: {what}")
    monkeypatch.setattr(plan_folder, "card", lambda choice, model, envelope, noise, files: "text")
    monkeypatch.setattr("reports.driver_card.driver_card", lambda title, text, *rest: f"{title} {text}")
    folder = tmp_path / "plans" / "first"
    for _ in range(2):
        told = plan_folder.write_plan(choice, MODEL, Envelope(), {}, folder, "step")
    assert set(told) == {"scenario", "commands", "robot", "card"}
    assert (folder / "step.xodr").read_text() == "road 90"
    assert Path(told["scenario"]).read_text() == "step.xodr: Brake: shows mass, drag"
    assert Path(told["card"]).read_text() == "Brake text"
    assert sorted(path.name for path in folder.iterdir()) == sorted(
        ["step.xodr", *(Path(path).name for path in told.values())]
    )
    choice.exciting = False
    told = plan_folder.write_plan(choice, MODEL, Envelope(), {}, folder, "step")
    assert Path(told["scenario"]).read_text() == "step.xodr: Brake: decides between mass, drag"


def test_a_file_that_cannot_be_written_leaves_nothing_behind(tmp_path: Path) -> None:
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "x").write_text("")
    with pytest.raises(OSError, match="taken"):
        plan_folder._write(tmp_path / "taken", "text")
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]


# --- what is chosen and advised


class Seen:
    """A rehearsal in which every other effect leaves 0.4 of chi^2/N after its refit."""

    def __init__(self, count: int) -> None:
        self.count = count

    def refitted(self, other: Any) -> float:
        return 0.4 * self.count

    def channels(self, values: Any) -> dict[str, float]:
        return {"v": 1.0}

    def largest(self, values: Any, channel: str) -> tuple[float, float]:
        return 1.0, 0.5


def test_the_drive_that_is_advised_is_that_of_the_first_effect(monkeypatch: pytest.MonkeyPatch) -> None:
    """And as many drives are looked at as there are effects."""
    monkeypatch.setattr(RehearsalInputs, "rehearse", lambda self, drive, truth: Seen(drive.count))
    asked = RehearsalInputs(MODEL, {}, Envelope(), {}, ())
    mine: list[Any] = [SimpleNamespace(name=name, values={}) for name in "ab"]
    drives: list[Any] = [SimpleNamespace(count=200), SimpleNamespace(count=100)]
    looked = _Looked(asked, drives, mine, mine, Evidence(100), set())
    assert looked.drive is drives[0]
    assert [s.gap for s in looked.signs] == pytest.approx([0.4, 0.4])
    assert looked.worth == pytest.approx(0.4 * 100 / (100 + 100))  # beside 100 samples, with those of the last drive
    assert looked.joint(3) == pytest.approx(0.4 * 300 / 400)
    with pytest.raises(ValueError, match="longer"):
        _Looked(asked, drives[:1], mine, mine, Evidence(), set())


def test_two_effects_or_more_are_fitted_to_the_logs_that_there_are(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []
    target = SimpleNamespace(count=500, noise=lambda: {"v": 0.03})
    monkeypatch.setattr(advice, "experiment_set", lambda logs, model, extra: target)
    monkeypatch.setattr(advice, "candidates_by_name", lambda model, names, effects: {n: n for n in names})
    monkeypatch.setattr(
        advice, "_fitted", lambda t, c, rest: SimpleNamespace(values={(c, "k"): 0.5}, chi2=500.0 + len(c))
    )
    monkeypatch.setattr(advice, "decide", lambda *given, **more: asked.append((given, more)))
    log: Any = object()
    between(("mass", "drag2"), {"a": log}, MODEL, Envelope())
    ((_, known, noise, _), more) = asked[-1]
    assert known == {"mass": {("mass", "k"): 0.5}, "drag2": {("drag2", "k"): 0.5}}
    assert noise == {"v": 0.03}
    assert (more["evidence"].samples, more["evidence"].left) == (500, {"mass": 504.0, "drag2": 505.0})
    for names, logs in ((("mass", "drag2"), {}), (("mass", "mass"), {"a": log}), (("mass",), {"a": log})):
        between(names, logs, MODEL, Envelope())
        ((_, known, noise, _), more) = asked[-1]
        assert (known, noise, "evidence" in more) == ({name: {} for name in names}, None, False)


def test_an_effect_that_the_model_has_is_taken_out_and_counts_with_its_values(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []
    monkeypatch.setattr(advice, "decide", lambda *given, **more: asked.append(given))
    model = MODEL.with_effect("mass", {"ratio": 1.25}).with_effect("drive_gain", {"g": 0.9})
    between(("mass", "brake_gain"), {}, model, Envelope())
    ((used, known, *_),) = asked
    assert [a.name for a in used.effects] == ["drive_gain"]
    assert known == {"mass": {("mass", "ratio"): 1.25}, "brake_gain": {}}


class Candidate:
    """An effect with a value that leaves a given chi^2 at each of its points."""

    def __init__(self, name: str, *leaves: float) -> None:
        self.name = name
        self.coordinates = (SimpleNamespace(key=SimpleNamespace(name="k")),)
        self.points = [{(name, "k"): chi2} for chi2 in leaves]


def left(values: Any) -> Any:
    """One residual whose square is the largest value that there is."""
    return np.array([math.sqrt(max(values.values(), default=0.0))])


@pytest.fixture
def logs(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A function that says which effects there are, and what each leaves where it is fitted."""

    def given(fits: dict[str, float], count: int = 100) -> Any:
        every = [Candidate(name, 900.0, 2.0 * chi2) for name, chi2 in fits.items()]
        monkeypatch.setattr(advice, "candidates", lambda model, effects: every)
        monkeypatch.setattr(advice, "candidates_by_name", lambda model, names, effects: {})
        monkeypatch.setattr(
            advice,
            "_fitted",
            lambda target, c, rest: SimpleNamespace(chi2=fits[c.name], values={(c.name, "k"): fits[c.name]}),
        )
        return SimpleNamespace(count=count, whitened=left)

    return given


def test_effects_that_the_logs_hardly_rule_out_are_those_a_quarter_behind(logs: Any) -> None:
    """The first, as given and not as it would be fitted, leaves 400 of 100 samples: a quarter of that are 100. A rival
    is fitted, and is not near."""
    target = logs({"a": 390.0, "b": 420.0, "c": 499.0, "d": 500.0, "e": 430.0})
    known, evidence = _hypotheses(target, MODEL, ("a", "b"), {("a", "k"): 400.0}, {("known", "k"): 1.0}, ())
    assert known == {"a": {("a", "k"): 400.0}, "b": {("b", "k"): 420.0}}
    assert evidence.near == {"e": {("e", "k"): 430.0}, "c": {("c", "k"): 499.0}}
    assert evidence.left == pytest.approx({"a": 400.0, "b": 420.0, "c": 499.0, "e": 430.0})
    assert evidence.samples == 100
    _, little = _hypotheses(logs({"a": 9.0, "b": 33.9, "c": 34.0}), MODEL, ("a",), {("a", "k"): 9.0}, {}, ())
    assert set(little.near) == {"b"}  # a quarter of the samples, where less than the noise is left


def test_of_the_eight_that_come_nearest_at_their_points_four_are_near_at_most(logs: Any) -> None:
    fits = {"a": 200.0} | {f"n{k}": 201.0 + k for k in range(12)}
    _, evidence = _hypotheses(logs(fits), MODEL, ("a",), {("a", "k"): 200.0}, {}, ())
    assert sorted(evidence.near) == ["n0", "n1", "n2", "n3"]
    far = {"a": 200.0} | {f"n{k}": 300.0 + k for k in range(7)} | {"p": 320.0, "q": 321.0}
    for name, near in (("p", True), ("q", False)):  # the eighth and the ninth at their points
        target = logs(far)
        fitted = advice._fitted

        def better(target: Any, c: Any, rest: Any, name: str = name, fitted: Any = fitted) -> Any:
            return SimpleNamespace(chi2=210.0, values={}) if c.name == name else fitted(target, c, rest)

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(advice, "_fitted", better)
            _, evidence = _hypotheses(target, MODEL, ("a",), {("a", "k"): 200.0}, {}, ())
        assert (name in evidence.near) is near


def test_a_fit_begins_at_the_point_that_leaves_least_beside_what_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(advice, "fit", lambda target, coordinates, begin, fixed: (coordinates, begin, fixed))
    one = Candidate("a", 7.0, 3.0, 5.0)
    target: Any = SimpleNamespace(whitened=lambda values: left({k: v for k, v in values.items() if k[0] == "a"}))
    rest = {("known", "k"): 1.0}
    assert _fitted(target, one, rest) == (one.coordinates, {("a", "k"): 3.0}, rest)  # type: ignore[arg-type, comparison-overlap]


def named(name: str, *rivals: str, action: str = "add") -> Any:
    return SimpleNamespace(name=name, rivals=rivals, action=action)


def test_each_effect_with_rivals_has_a_manoeuvre_that_decides_and_the_rest_one_that_shows_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[Any] = []

    def hypotheses(target: Any, model: Any, names: Any, first: Any, rest: Any, effects: Any) -> Any:
        asked.append((names, first, rest))
        return {}, Evidence()

    def deciding(model: Any, known: Any, noise: Any, envelope: Any, **more: Any) -> str:
        if asked[-1][0][0] == "drag":
            raise PlanError("too small a ground")
        return f"decides {asked[-1][0][0]}"

    def exciting(model: Any, names: Any, noise: Any, envelope: Any, **more: Any) -> Any:
        asked.append((names, more["beside"], more["shared"]))
        if names == ("nothing",):
            raise PlanError("no manoeuvre shows nothing")
        return ("shows",)

    monkeypatch.setattr(advice, "experiment_set", lambda logs, model, extra: SimpleNamespace(count=700))
    monkeypatch.setattr(advice, "_hypotheses", hypotheses)
    monkeypatch.setattr(advice, "decide", deciding)
    monkeypatch.setattr(advice, "excite", exciting)
    values = {("mass", "ratio"): 1.1, ("drag", "k"): 0.1}
    found: Any = SimpleNamespace(
        noise_floor={"v": 0.03}, values=values, not_excited=("lag",),
        effects=[named("mass", "r1", "r2", "r3", "r4", "r5"), named("sure"), named("gone", "r1", action="remove"),
                 named("drag", "lag")],
    )  # fmt: skip
    told = advise(found, {}, MODEL, Envelope())
    assert asked == [
        (("mass", "r1", "r2", "r3", "r4"), {("mass", "ratio"): 1.1}, {("drag", "k"): 0.1}),
        (("drag", "lag"), {("drag", "k"): 0.1}, {("mass", "ratio"): 1.1}),
        (("lag",), 700, values),
    ]
    assert told.deciding == {"mass": "decides mass"}
    assert told.refused == ("drag or lag: too small a ground",)
    assert told.choices == ("decides mass", "shows")
    assert advise(found, {}, MODEL, Envelope(), exciting=False).exciting == ()
    found.not_excited = ("nothing",)
    assert advise(found, {}, MODEL, Envelope()).refused[-1] == "no manoeuvre shows nothing"
    found.not_excited = ()
    assert len(advise(found, {}, MODEL, Envelope()).refused) == 1


def test_what_shows_an_effect_is_seen_beside_the_logs_that_there_are(monkeypatch: pytest.MonkeyPatch) -> None:
    """Their samples, which show nothing of it, dilute what a drive more shows; its sensors are theirs."""
    asked: list[Any] = []

    def exciting(model: Any, names: Any, noise: Any, envelope: Any, **more: Any) -> Any:
        asked.append((names, noise, more.get("beside", 0)))
        return ()

    target = SimpleNamespace(count=700, noise=lambda: {"v": 0.03})
    monkeypatch.setattr(advice, "experiment_set", lambda logs, model, extra: target)
    monkeypatch.setattr(advice, "excite", exciting)
    log: Any = object()
    advice.showing(["lag"], {"town.csv": log}, MODEL, Envelope())
    advice.showing(["lag"], {}, MODEL, Envelope())
    assert asked == [(["lag"], {"v": 0.03}, 700), (["lag"], None, 0)]


@pytest.mark.parametrize(("gap", "looked_at"), [(0.9, 2), (0.89, 1)])
def test_a_second_manoeuvre_is_looked_at_closely_if_it_promises_nine_tenths(
    gap: float, looked_at: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of three that do as well two are looked at."""
    gaps = {"first": 1.0, "second": gap, "third": gap}
    looked: list[str] = []

    class Look:
        def __init__(self, asked: Any, drives: Any, *rest: Any) -> None:
            self.drive, self.worth = drives[0], 1.0
            looked.append(self.drive.manoeuvre.name)
            self.signs = (SimpleNamespace(other="mass", gap=1.0),)

        def joint(self, repeats: int) -> float:
            return 1.0

        def gaps(self, repeats: int) -> Any:
            return {}

    def performed(manoeuvre: Any, *rest: Any) -> Any:
        return SimpleNamespace(manoeuvre=manoeuvre, seconds=10.0, size=1.0)

    monkeypatch.setattr(choosing, "perform", performed)
    monkeypatch.setattr(discrimination, "_screened", lambda a, d, *rest: {("a", "b"): gaps[d.manoeuvre.name]})
    monkeypatch.setattr(RehearsalInputs, "together", lambda asked, drive, truths: [drive])
    monkeypatch.setattr(discrimination, "_Looked", Look)
    hypotheses = {"drive_gain": {("drive_gain", "g"): 0.9}, "mass": {("mass", "ratio"): 1.1}}
    found = decide(MODEL, hypotheses, manoeuvres=[SimpleNamespace(name=name) for name in gaps])  # type: ignore[misc, arg-type]
    assert looked == list(gaps)[:looked_at]
    for pair, weak in ((("drive_gain", "near"), True), (("mass", "near"), False)):  # near the first one, or another
        monkeypatch.setattr(Look, "gaps", lambda self, repeats, pair=pair: {pair: 0.049})
        one = [SimpleNamespace(name="first")]
        assert decide(MODEL, hypotheses, manoeuvres=one).weak is weak  # type: ignore[arg-type]
    monkeypatch.setattr(Look, "gaps", lambda self, repeats: {})
    assert found.ranking == gaps
    assert (found.repeats, found.weak, found.gap) == (1, False, 1.0)


def test_a_rival_is_fitted_from_the_best_of_its_own_values_and_its_points(monkeypatch: pytest.MonkeyPatch) -> None:
    """For six rounds at most, while one gains a thousandth of the samples; what is sure beside stays."""
    asked: list[Any] = []

    def fitted(target: Any, coordinates: Any, begin: Any, *, fixed: Any, stop: Any = None) -> Any:
        asked.append((target.experiments, coordinates, begin, fixed, stop))
        return SimpleNamespace(chi2=7.0, values={("a", "k"): 2.5})

    monkeypatch.setattr(rehearsal, "fit", fitted)
    one = object.__new__(Rehearsal)
    one.experiment = SimpleNamespace(  # type: ignore[assignment]
        whitened=lambda values: np.array([values["a", "k"] - 3.0 + values["sure", "k"]])
    )
    one.shared, one.count, one._of_truth = {("sure", "k"): 0.0}, 4000, np.array([0.0])
    candidate: Any = Candidate("a", 9.0, 4.0)
    for own, begin in ((1.0, 4.0), (2.5, 2.5)):
        assert one.refitted(Hypothesis(candidate, {("a", "k"): own})) == 7.0
        experiments, coordinates, begun, fixed, stop = asked[-1]
        assert (experiments, coordinates, fixed) == ((one.experiment,), candidate.coordinates, one.shared)
        assert begun == {("a", "k"): begin}
        assert (stop.rounds, stop.enough) == (6, pytest.approx(4.0))
    for left, beyond in ((1.0, 6.0), (3.0, 0.0)):  # 9 of the truth are more than 7
        one._of_truth = np.array([left])
        assert one.refitted(Hypothesis(candidate, {("a", "k"): 1.0})) == beyond
    one._of_truth = np.array([0.0])
    assert closest_values(one, candidate) == {("a", "k"): 2.5}
    assert asked[-1][2] == {("a", "k"): 4.0}


def test_the_noise_of_a_usual_car_is_about_that_of_the_twin_s_own_sensors() -> None:
    """No more than three times as much or as little: with metres for centimetres every manoeuvre would look weak."""
    gnss, imu, wheels = (sensor(None, None) for sensor in (Gnss, InertialUnit, WheelOdometry))
    assert gnss.yaw_sigma is not None
    own = {"x": gnss.sigma, "y": gnss.sigma, "yaw": gnss.yaw_sigma, "v": wheels.sigma, "yaw_rate": imu.gyro_sigma,
           "ax": imu.accel_sigma, "ay": imu.accel_sigma}  # fmt: skip
    assert set(NOISE) == set(own)
    for name, sigma in own.items():
        assert sigma / 3.0 < NOISE[name] < 3.0 * sigma


def test_effects_without_values_are_made_like_the_first_in_a_gentle_drive_about_town(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It is driven once, smaller than any other manoeuvre if need be, with the first one's values."""
    driven: list[Any] = []

    def gently(manoeuvre: Any, model: Any, values: Any, envelope: Any, sizes: Any, effects: Any) -> Any:
        driven.append((manoeuvre, values, sizes))
        return "drive" if sizes[-1] == 0.4 else None

    monkeypatch.setattr(choosing, "perform", gently)
    monkeypatch.setattr(RehearsalInputs, "rehearse", lambda self, drive, truth: (drive, truth))
    monkeypatch.setattr(discrimination, "closest_values", lambda town, c: {(c.name, "k"): 0.5, town[0]: town[1]})
    asked = RehearsalInputs(MODEL, {}, Envelope(), {("sure", "k"): 1.0}, ())
    wanted: list[Any] = [Candidate("a", 1.0, 2.0, 3.0), Candidate("b", 1.0), Candidate("c", 1.0), Candidate("d", 1.0)]
    own = {("c", "k"): 9.0}
    found = discrimination._complete(asked, wanted, {"a": {}, "b": {}, "c": own, "d": {}})
    assert [h.name for h in found] == ["a", "b", "c", "d"]
    first = {("a", "k"): 2.0}  # the middle of its points
    assert found[0].values == first
    assert found[1].values == {("b", "k"): 0.5, "drive": first}
    assert found[2].values == own
    assert found[3].values == {("d", "k"): 0.5, "drive": first}
    assert [(m.name, values, sizes[:4]) for m, values, sizes in driven] == [
        (discrimination.CITY.name, {("sure", "k"): 1.0} | first, simulated_drive.SIZES)
    ]
    monkeypatch.setattr(choosing, "perform", lambda *asked: None)
    with pytest.raises(PlanError, match="not even a gentle drive keeps within the envelope; widen it"):
        discrimination._complete(asked, wanted, {"a": {}, "b": {}, "c": {}, "d": {}})
