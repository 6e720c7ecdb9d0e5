"""Which manoeuvre is advised: on drives in which what each effect changes is given, each bound from both sides."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.compare.segments import CHANNELS
from pytest_dvp.gap.diagnose.candidates import candidates
from pytest_dvp.gap.manoeuvres import choice as choosing
from pytest_dvp.gap.manoeuvres.catalogue import MANOEUVRES
from pytest_dvp.gap.manoeuvres.choice import Choice, LargestDifference, PlanError, RehearsalInputs, as_named, sign_of
from pytest_dvp.gap.manoeuvres.discrimination import Evidence, _tied, decide
from pytest_dvp.gap.manoeuvres.driver_card import as_dict, card
from pytest_dvp.gap.manoeuvres.driving_limits import Area, Envelope
from pytest_dvp.gap.manoeuvres.exciting_manoeuvres import excite
from pytest_dvp.gap.manoeuvres.rehearsal import NOISE as SENSORS
from pytest_dvp.gap.manoeuvres.rehearsal import Hypothesis, Rehearsal, separable_chi2, typical
from pytest_dvp.gap.manoeuvres.simulated_drive import Drive, perform
from tests.unit.gap.linear_world import tried
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.model_file import parse_model

DRIVE, BRAKE, RATIO = ("drive_gain", "g"), ("brake_gain", "g"), ("steer_ratio", "g")
KEYS = {"drive_gain": DRIVE, "brake_gain": BRAKE, "steer_ratio": RATIO}
COUNT = 100
MODEL: Any = parse_model("[model]\nname = 'c'\n[parameters]\nwheelbase = 2.5\n")


def a_drive(name: str, seconds: float, size: float = 1.0, **given: Any) -> Drive:
    manoeuvre: Any = SimpleNamespace(name=name, title=name.title(), source="", what="drive it", round_about=False)
    for key, value in given.items():
        setattr(manoeuvre, key, value)
    t = np.array([0.0, seconds])
    motion = np.array([[0.0, 0.0, 0.0, 10.0, 0.1], [30.0, -4.0, 0.0, 5.0, -0.4]])
    return Drive(
        manoeuvre, size, Area(-5.0, 90.0, -8.0, 52.0), t, np.array([[1.5, 0.1, 0.0], [-2.0, -0.2, 0.0]]), motion
    )


class Shows:
    """A rehearsal of a drive in which each effect changes chi^2/N by (value - that of the truth)^2 of its vector."""

    def __init__(self, does: dict[str, Any], truth: Any) -> None:
        self.does, self.truth, self.count = does, dict(truth), COUNT

    def whitened(self, values: Any) -> Any:
        found = np.zeros(3)
        for name, row in self.does.items():
            key = KEYS[name]
            found += (values.get(key, 1.0) - self.truth.get(key, 1.0)) * np.asarray(row, dtype=float)
        return found

    def tangent(self, hypothesis: Hypothesis, at: Any) -> Any:
        return 0.01 * np.asarray(self.does.get(hypothesis.name, np.zeros(3)), dtype=float)[:, None]

    def refitted(self, other: Hypothesis) -> float:
        return separable_chi2(self.whitened(other.values), self.tangent(other, None))

    def channels(self, values: Any) -> dict[str, float]:
        return {"v": 0.3, "yaw": 0.7}

    def largest(self, values: Any, channel: str) -> tuple[float, float]:
        return 4.0, -0.2


@pytest.fixture
def shown(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A function that says what manoeuvres there are: name -> (seconds, what each effect does in it)."""

    def given(drives: dict[str, tuple[float, dict[str, Any]]]) -> list[Any]:
        def perform(manoeuvre: Any, *_: Any) -> Any:
            return a_drive(manoeuvre.name, drives[manoeuvre.name][0]) if manoeuvre.name in drives else None

        monkeypatch.setattr(choosing, "perform", perform)
        monkeypatch.setattr(RehearsalInputs, "rehearse",
                            lambda self, drive, truth: Shows(drives[drive.manoeuvre.name][1], truth))  # fmt: skip
        return [SimpleNamespace(name=name) for name in [*drives, "not driven"]]

    return given


def apart(gap: float) -> dict[str, Any]:
    """Two effects whose changes are at right angles: with a value of 0.9 each leaves so much of chi^2/N."""
    size = 10.0 * np.sqrt(gap * COUNT)
    return {"drive_gain": [size, 0.0, 0.0], "brake_gain": [0.0, size, 0.0]}


TWO: Any = {"drive_gain": {DRIVE: 0.9}, "brake_gain": {BRAKE: 0.9}}


def decided(manoeuvres: Any, **given: Any) -> Choice:
    return decide(MODEL, given.pop("hypotheses", TWO), manoeuvres=manoeuvres, **given)


def test_the_manoeuvre_with_the_largest_gap_is_chosen_and_of_those_as_good_the_shortest(shown: Any) -> None:
    found = decided(shown({"long": (60.0, apart(1.0)), "short": (30.0, apart(0.91)), "poor": (10.0, apart(0.5))}))
    assert found.manoeuvre.name == "short"
    assert found.gap == pytest.approx(0.91)
    assert found.ranking == pytest.approx({"long": 1.0, "short": 0.91, "poor": 0.5})
    assert (found.effects, found.exciting, found.repeats, found.weak) == (("drive_gain", "brake_gain"), False, 1, False)
    signs = {(s.truth, s.other): s for s in found.signs}
    assert set(signs) == {("drive_gain", "brake_gain"), ("brake_gain", "drive_gain")}
    assert (found.signs[0].channel, found.signs[0].time, found.signs[0].difference) == ("yaw", 4.0, -0.2)
    worse = decided(shown({"long": (60.0, apart(1.0)), "short": (30.0, apart(0.89))}))
    assert worse.manoeuvre.name == "long"


@pytest.mark.parametrize(
    ("gap", "repeats", "weak"), [(0.151, 1, False), (0.149, 2, False), (0.051, 5, False), (0.049, 5, True)]
)
def test_it_is_repeated_until_the_gap_is_three_times_what_a_diagnosis_needs(
    shown: Any, gap: float, repeats: int, weak: bool
) -> None:
    """With 10 samples of logs beside, k drives of 100 have a gap of k 100/(10 + k 100) of the drive's."""
    evidence = Evidence(0) if repeats in (1, 5) else Evidence(10)
    drive = gap if repeats in (1, 5) else 0.158  # 0.144 with one, 0.1505 with two
    found = decided(shown({"a": (30.0, apart(drive))}), evidence=evidence)
    assert (found.repeats, found.weak) == (repeats, weak)


def test_gaps_of_logs_and_drives_are_joint() -> None:
    evidence = Evidence(400, {"a": 500.0, "b": 620.0})
    assert evidence.joint("a", "b", 0.5, 100, 2) == pytest.approx((120.0 + 100.0) / 600.0)
    assert evidence.joint("b", "a", 0.5, 100) == pytest.approx(50.0 / 500.0)
    assert evidence.joint("a", "c", 0.5, 100) == pytest.approx(50.0 / 500.0)
    assert Evidence().joint("a", "b", 0.5, 0) == 0.0


def test_what_no_manoeuvre_tells_from_what_was_not_asked_about_does_not_bear_on_the_choice() -> None:
    pairs = ("a", "b"), ("a", "near")
    for gap, tied in ((0.049, {("a", "near")}), (0.051, set())):
        assert (
            _tied({"a", "b"}, [dict(zip(pairs, (0.01, 0.0), strict=True)), dict(zip(pairs, (0.02, gap), strict=True))])
            == tied
        )


def test_an_effect_near_the_best_must_be_told_apart_as_well(shown: Any) -> None:
    does = apart(1.0) | {"steer_ratio": [0.0, 0.0, 10.0 * np.sqrt(0.3 * COUNT)]}
    manoeuvres = shown({"a": (30.0, does)})
    found = decided(manoeuvres, evidence=Evidence(0, {}, {"steer_ratio": {RATIO: 0.9}}))
    assert found.gap == pytest.approx(1.0)
    assert {s.other for s in found.signs} == {"drive_gain", "brake_gain"}
    assert found.ranking["a"] == pytest.approx(1.0)  # of another one only what it explains of the truth counts


def test_what_cannot_be_decided_is_one_line(shown: Any) -> None:
    manoeuvres = shown({"a": (30.0, apart(1.0))})
    with pytest.raises(PlanError, match="drive_gain alone, name two or more"):
        decided(manoeuvres, hypotheses={"drive_gain": {}})
    with pytest.raises(PlanError, match="no effect alone"):
        decided(manoeuvres, hypotheses={})
    with pytest.raises(PlanError, match="no manoeuvre keeps within the envelope; widen it"):
        decided(shown({}))
    with pytest.raises(PlanError, match="did you mean 'drive_gain'"):
        decided(manoeuvres, hypotheses={"drive_gian": {}, "brake_gain": {}})
    with pytest.raises(PlanError, match="detection_latency cannot be planned for"):
        decided(manoeuvres, hypotheses={"detection_latency": {}, "brake_gain": {}})


def test_a_drive_is_as_large_as_keeps_every_rival_within_the_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    fits = {0.9: 1.0, 0.8: 0.7}

    def perform(manoeuvre: Any, model: Any, values: Any, envelope: Any, sizes: Any, effects: Any) -> Any:
        (size,) = sizes
        return a_drive("a", 30.0, size) if size <= fits[values[DRIVE]] else None

    monkeypatch.setattr(choosing, "perform", perform)
    asked = RehearsalInputs(MODEL, {}, Envelope(), {}, ())
    mine = [{DRIVE: value} for value in (0.9, 0.8)]
    assert [d.size for d in asked.together(a_drive("a", 30.0, 1.0), mine)] == [0.7, 0.7]
    assert [d.size for d in asked.together(a_drive("a", 30.0, 0.7), mine)] == [0.7, 0.7]
    fits[0.8] = 0.5
    assert asked.together(a_drive("a", 30.0, 1.0), mine) == []


def excited(manoeuvres: Any, *names: str, **given: Any) -> tuple[Choice, ...]:
    return excite(MODEL, names, manoeuvres=manoeuvres, **given)


def alone(**gaps: float) -> dict[str, Any]:
    """What each effect of typical size changes of chi^2/N, all at right angles."""
    found = {}
    for k, (name, gap) in enumerate(gaps.items()):
        (candidate,) = tried(name)
        size = typical(candidate.coordinates, candidate.points)[KEYS[name]] - 1.0
        row = np.zeros(3)
        row[k] = np.sqrt(gap * COUNT) / abs(size)
        found[name] = row
    return found


def test_the_fewest_drives_that_show_all_are_chosen(shown: Any) -> None:
    manoeuvres = shown({"both": (50.0, alone(drive_gain=0.2, brake_gain=0.2)), "drive": (20.0, alone(drive_gain=9.0)),
                        "brake": (20.0, alone(brake_gain=9.0))})  # fmt: skip
    (found,) = excited(manoeuvres, "drive_gain", "brake_gain")
    assert (found.manoeuvre.name, found.effects, found.exciting) == ("both", ("drive_gain", "brake_gain"), True)
    assert found.gap == pytest.approx(0.2)
    assert found.ranking == pytest.approx({"both": 0.2, "drive": 0.0, "brake": 0.0})
    assert (found.repeats, found.weak, found.not_shown) == (1, False, ())
    weaker = shown({"both": (50.0, alone(drive_gain=0.2, brake_gain=0.149)), "brake": (20.0, alone(brake_gain=9.0))})
    first, second = excited(weaker, "drive_gain", "brake_gain")
    assert {first.manoeuvre.name, second.manoeuvre.name} == {"both", "brake"}


def test_a_drive_is_as_large_as_keeps_the_effects_that_it_shows_within_the_limits(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With 15 % more drive, only 0.7 of the drive keeps within them; what it shows grows with the square of its size.
    If no size does, another drive is taken, or none."""
    fits, asked = {"a": 0.7, "b": 1.0}, []

    def perform(manoeuvre: Any, model: Any, values: Any, envelope: Any, sizes: Any, effects: Any) -> Any:
        most = fits[manoeuvre.name] if values.get(DRIVE, 1.0) > 1.0 else 1.0
        asked.append(set(values))
        return next((a_drive(manoeuvre.name, 30.0, size) for size in sizes if size <= most), None)

    monkeypatch.setattr(choosing, "perform", perform)
    does = {"a": alone(drive_gain=1.0), "b": alone(drive_gain=0.4)}
    monkeypatch.setattr(
        RehearsalInputs, "rehearse", lambda self, drive, truth: Shows(
            {name: drive.size * row for name, row in does[drive.manoeuvre.name].items()}, truth),
    )  # fmt: skip
    both: Any = [SimpleNamespace(name="a"), SimpleNamespace(name="b")]
    (found,) = excited(both, "drive_gain")
    assert (found.manoeuvre.name, found.drive.size, found.gap) == ("a", 0.7, pytest.approx(0.49))
    fits["a"] = 0.5
    (found,) = excited(both, "drive_gain")
    assert (found.manoeuvre.name, found.drive.size) == ("b", 1.0)
    with pytest.raises(PlanError, match="no manoeuvre shows drive_gain within these limits"):
        excited(both[:1], "drive_gain")
    asked.clear()
    excited(both[1:], "drive_gain")
    assert {DRIVE} in asked


@pytest.mark.parametrize(("short", "chosen"), [(0.51, "short"), (0.49, "long")])
def test_a_shorter_drive_that_shows_half_as_much_is_taken(shown: Any, short: float, chosen: str) -> None:
    manoeuvres = shown({"long": (50.0, alone(drive_gain=1.0)), "short": (20.0, alone(drive_gain=short))})
    assert excited(manoeuvres, "drive_gain")[0].manoeuvre.name == chosen


def test_what_nothing_shows_is_told_and_alone_refused(shown: Any) -> None:
    manoeuvres = shown({"a": (20.0, alone(drive_gain=1.0, brake_gain=0.149))})
    (found,) = excited(manoeuvres, "drive_gain", "brake_gain")
    assert (found.effects, found.not_shown) == (("drive_gain",), ("brake_gain",))
    with pytest.raises(PlanError, match="no manoeuvre shows brake_gain within these limits"):
        excited(manoeuvres, "brake_gain")
    with pytest.raises(PlanError, match="widen it"):
        excited(shown({}), "brake_gain")


@pytest.mark.parametrize(
    ("beside", "repeats", "weak"),
    [(33, 1, False), (34, 2, False), (166, 5, False), (1400, 5, False), (1600, 5, True)],
)
def test_logs_beside_make_repeats_necessary(shown: Any, beside: int, repeats: int, weak: bool) -> None:
    """k drives of 100 samples with a gap of 0.2 beside n: 0.2 k 100/(n + k 100), of which 0.15 are enough and 0.05
    the least that counts."""
    (found,) = excited(shown({"a": (20.0, alone(drive_gain=0.2))}), "drive_gain", beside=beside)
    assert (found.repeats, found.weak) == (repeats, weak)


def test_an_effect_that_another_explains_as_well_counts_by_what_is_left(shown: Any) -> None:
    """The brake does 0.6 of what the drive does: 1 - 0.36 is left. Effects that no usual data tell apart are excepted,
    and where nothing tells it apart what shows at all counts."""
    does = alone(drive_gain=1.0, steer_ratio=1.0)
    scale = np.linalg.norm(does["drive_gain"])
    does["steer_ratio"] = scale * np.array([0.6, 0.8, 0.0])
    (found,) = excited(shown({"a": (20.0, does)}), "drive_gain")
    assert found.gap == pytest.approx(0.64)
    does["steer_ratio"] = scale * np.array([1.0, 1e-3, 0.0])
    (same,) = excited(shown({"a": (20.0, does)}), "drive_gain")
    assert same.gap == pytest.approx(1.0)


def test_what_was_asked_for_by_name_is_driven_as_large_as_it_may(shown: Any) -> None:
    manoeuvres = shown({"a": (20.0, {})})
    (found,) = as_named(manoeuvres[:1], MODEL, Envelope())
    assert (found.effects, found.exciting, found.gap, found.repeats, found.weak) == ((), True, 0.0, 1, False)
    with pytest.raises(PlanError, match="not driven does not keep within these limits, or lasts longer than 180 s; "):
        as_named(manoeuvres, MODEL, Envelope())


def a_rehearsal(r: Any) -> Rehearsal:
    """A rehearsal of four rows in which values leave r (4, 8)."""
    found = object.__new__(Rehearsal)
    found.drive = SimpleNamespace(t=np.array([0.0, 0.1, 0.2, 0.3]))  # type: ignore[assignment]
    sigma = np.full(8, np.inf)
    sigma[[3, 4]] = 0.03, 0.005
    found.experiment = SimpleNamespace(  # type: ignore[assignment]
        whitened=lambda values: np.asarray(r(values) if callable(r) else r).ravel(),
        channels=("v", "yaw_rate"),
        sigma=sigma,
    )
    found.shared, found.count = {("known", "k"): 1.0}, 16
    found._of_truth = np.zeros(32)
    return found


def test_where_values_differ_most_is_told_in_the_unit_of_the_channel() -> None:
    r = np.zeros((4, 8))
    r[:, CHANNELS.index("v")] = [1.0, -3.0, 2.0, 0.0]
    r[:, CHANNELS.index("yaw_rate")] = [0.0, 1.0, -1.0, 4.0]
    rehearsal = a_rehearsal(r)
    assert rehearsal.channels({}) == pytest.approx({"v": 14.0 / 32.0, "yaw_rate": 18.0 / 32.0})
    assert rehearsal.largest({}, "v") == pytest.approx((0.1, -0.09))
    assert rehearsal.largest({}, "yaw_rate") == pytest.approx((0.3, 0.02))
    (candidate,) = tried("drive_gain")
    assert sign_of(rehearsal, "a", Hypothesis(candidate, {DRIVE: 0.9}), 0.5) == LargestDifference(
        "a", "drive_gain", 0.5, "yaw_rate", 0.3, pytest.approx(0.02), "g = 0.9"
    )  # fmt: skip
    assert a_rehearsal(np.zeros((4, 8))).channels({}) == {"v": 0.0, "yaw_rate": 0.0}


def test_what_the_truth_itself_leaves_is_no_difference() -> None:
    """A yaw rate that is shown late knows nothing of what came before a segment: a step that begins one leaves an error
    of its own, which 30 effects that did nothing had been said to show."""
    model = parse_model(
        "[inputs]\nlongitudinal = 'v'\nsteer = 'steer_cmd'\n[parameters]\nwheelbase = 2.97\nmass = 790.0\n"
    )
    late = {("yaw_rate_latency", "T"): 0.3, ("steer_compliance", "c"): 0.0049}
    (step,) = [m for m in MANOEUVRES if m.name == "step_steer"]
    drive = perform(step, model, late, Envelope())
    assert drive is not None
    drag = {("aero_drag", "k"): 0.004}
    rehearsal = Rehearsal(drive, model, {}, SENSORS, shared=late)
    assert float(np.abs(rehearsal.experiment.whitened(late)).max()) > 1.0
    assert not rehearsal.whitened(drag).any()
    (candidate,) = candidates(model, [find_effect("gyro_bias")])
    biased = Rehearsal(drive, model, {("gyro_bias", "b"): 0.01}, SENSORS, shared=late)
    assert biased.refitted(Hypothesis(candidate, {("gyro_bias", "b"): 0.02})) < 0.01 * biased.count


@pytest.mark.parametrize(("value", "side"), [(0.9, 1.0), (1.1, -1.0)])
def test_a_tangent_is_a_step_of_24_thousandths_of_the_range_towards_its_middle(value: float, side: float) -> None:
    row = np.arange(32.0)
    rehearsal = a_rehearsal(lambda values: values[DRIVE] ** 2 * row + values["known", "k"])
    (candidate,) = tried("drive_gain")
    moved = value + side * 0.024 * 0.5  # of 0.7 to 1.2
    found = rehearsal.tangent(Hypothesis(candidate, {DRIVE: value}), value**2 * row + 1.0)
    assert found == pytest.approx((moved**2 - value**2) * row[:, None])


def test_what_parameters_cannot_take_away_is_at_right_angles_to_what_they_do() -> None:
    rng = np.random.default_rng(0)
    r, tangent = rng.normal(size=20), rng.normal(size=(20, 2))
    left = r - tangent @ np.linalg.lstsq(tangent, r, rcond=None)[0]
    assert separable_chi2(r, tangent) == pytest.approx(left @ left)
    assert separable_chi2(r, np.zeros((20, 0))) == pytest.approx(r @ r)
    assert separable_chi2(r, np.zeros((20, 1))) == pytest.approx(r @ r)


def test_typical_is_the_middle_of_the_points_or_of_the_range() -> None:
    (candidate,) = tried("drive_gain")
    points = [{DRIVE: value} for value in (0.1, 0.2, 0.3, 0.4)]
    assert typical(candidate.coordinates, points) == {DRIVE: 0.3}
    assert typical(candidate.coordinates, points[:3]) == {DRIVE: 0.2}
    assert typical(candidate.coordinates, []) == {DRIVE: pytest.approx(0.95)}


def a_choice(**given: Any) -> Choice:
    signs = (
        LargestDifference("a", "b", 0.2, "yaw_rate", 3.14, -0.0456, "g = 0.9"),
        LargestDifference("b", "a", 0.3, "v", 1.0, 0.5),
        LargestDifference("a", "c", 0.4, "v", 9.0, 1.234),
    )  # fmt: skip
    fields: dict[str, Any] = {
        "effects": ("a", "b"), "exciting": False, "drive": a_drive("step", 41.0, source="ISO 7401"), "gap": 0.234,
        "signs": signs, "ranking": {"step": 0.2}, "repeats": 2, "weak": False,
    }  # fmt: skip
    return Choice(**(fields | given))


NOISE = {"x": 0.02, "yaw": 0.005, "v": 0.03}


def test_a_card_says_what_to_drive_where_and_what_it_means() -> None:
    text = card(a_choice(), MODEL, Envelope(), NOISE, {"scenario": "p/step.xosc", "robot": "p/step.py"}, "my car.toml",
                ["a.csv"], ["--map", "f"])  # fmt: skip
    assert text.splitlines() == [
        "Step (ISO 7401)",
        "  why      tells a from b: in its log chi^2/N grows by 0.23 or more with a wrong one",
        "  drive    drive it",
        "           41 s, 2 times; from standstill to standstill, a log for each",
        "  where    flat, dry, free ground of 100 x 60 m; start 5 m from the end behind and 8 m from the right side",
        "           the path takes 30 x 4 m",
        "  speed    up to 10.0 m/s (36 km/h)",
        "  pedals   +1.5 to -2.0 m/s^2 asked for",
        "  steering up to 11.5 deg at the road wheels (times the steering ratio at the wheel in hand), 2.0 m/s^2 "
        "sideways",
        "  record   steer_cmd, accel_cmd, yaw, v at 50 Hz or more; x at 10 Hz or more, on one clock",
        "  means    a, if a model with b in its place differs in yaw_rate, most at 3.1 s by 0.046 rad/s",
        "           a, if a model with c in its place differs in v, most at 9.0 s by 1.2 m/s",
        "  scenario p/step.xosc",
        "  robot    p/step.py",
        "  rehearse dvp run p/step.xosc --ads p/step.py:Robot --model 'my car.toml' --duration 60",
        "  then     dvp diagnose a.csv step.csv --model 'my car.toml' --map f",
    ]
    even = card(a_choice(drive=a_drive("step", 40.0)), MODEL, Envelope(), {"v": 0.1}, {"scenario": "s", "robot": "r"})
    assert "Step\n" in even
    assert "--duration 50" in even
    assert "steer_cmd, accel_cmd, v at 50 Hz or more, on one clock" in even
    assert even.endswith("  then     dvp diagnose LOG... step.csv --model MODEL.toml")


def test_a_card_of_what_is_to_be_shown_and_of_what_was_asked_for() -> None:
    one = a_choice(
        exciting=True, effects=("b",), signs=a_choice().signs[:1], repeats=1, weak=True, not_shown=("x", "y")
    )
    lines = card(one, MODEL, Envelope(), NOISE, {}).splitlines()
    assert lines[1] == "  why      shows b, if the car has it"
    assert "41 s, once; from" in lines[3]
    means = "b of g = 0.9: differs in yaw_rate, most at 3.1 s by 0.046 rad/s; if not, the car has none of that size"
    assert lines[10] == f"  means    {means}"
    assert lines[11] == "  but      this is the best within these limits, and may well not be enough: widen them"
    assert lines[12] == "  not      x, y: nothing within these limits shows them"
    two = card(a_choice(exciting=True), MODEL, Envelope(), NOISE, {}).splitlines()
    assert two[1] == "  why      shows a, b, if the car has them"
    named = card(a_choice(effects=(), signs=()), MODEL, Envelope(), NOISE, {}).splitlines()
    assert named[1] == "  why      asked for by name; what it would show was not looked at"
    document = as_dict(a_choice(), {"scenario": "s"})
    assert (document["purpose"], document["max_speed"], document["max_lateral"]) == ("decide", 10.0, 2.0)
    assert (document["max_steer"], document["duration"], document["repeats"]) == (0.2, 41.0, 2)
    assert document["signs"][0] == {"truth": "a", "other": "b", "gap": 0.2, "channel": "yaw_rate", "time": 3.14,
                                    "difference": -0.0456, "unit": "rad/s"}  # fmt: skip
    assert as_dict(a_choice(exciting=True), {})["purpose"] == "excite"
    assert as_dict(a_choice(effects=()), {})["purpose"] == "named"
