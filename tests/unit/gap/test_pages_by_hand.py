"""What the pages of a comparison and of a diagnosis draw, from residuals that are written down here."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.compare.compare import SignalScore
from pytest_dvp.gap.compare.regimes import REGIMES
from pytest_dvp.gap.compare.segments import CHANNELS
from pytest_dvp.gap.diagnose.diagnosis import Diagnosis, Estimate, NamedEffect, Step
from pytest_dvp.gap.words import comparison_page, diagnosis_page
from pytest_dvp.gap.words.diagnosis_page import (
    Typed,
    _close,
    _Drawn,
    _level,
    _null_level,
    _over_time,
    _rest,
    _turned,
    _whole,
)

NAN = math.nan
X, Y, YAW, V, RATE = (CHANNELS.index(name) for name in ("x", "y", "yaw", "v", "yaw_rate"))

# --- a comparison


def compared(**more: Any) -> Any:
    """8 rows of 0.1 s; v 3 m/s for half of the time, then 12."""
    masks = {name: np.zeros(8, bool) for name in REGIMES} | {"launch": np.arange(8) < 4, "braking": np.arange(8) >= 6}
    score = SignalScore(rmse=0.5, unit="m/s", chi2_per_n=2.0, nrmse=0.1, mncc=0.9, lag=0.0, gain=1.0, iso18571=0.5)
    base: dict[str, Any] = {
        "model": "M", "t": 0.1 * np.arange(8.0), "signals": {"v": score, "ax": score}, "regimes": masks,
        "noise": {"v": 0.5, "ax": 2.0}, "speed": np.r_[np.full(4, 3.0), np.full(4, 12.0)],
        "residuals": {"v": np.r_[np.full(4, 1.0), NAN, NAN, 2.0, NAN], "ax": np.full(8, 6.0)},
        "measured": {"v": np.ones(8)}, "modelled": {}, "where": (), "not_compared": {}, "position": None,
        "slid": np.zeros(8, bool), "alignment": SimpleNamespace(lag=0.25, coverage=0.5),
        "segments": SimpleNamespace(starts=np.array([0, 5])),
    }  # fmt: skip
    return SimpleNamespace(**{**base, **more})


def test_groups_are_root_mean_squares_over_the_noise_where_there_are_samples() -> None:
    table = comparison_page._groups(compared())
    assert set(table) == {"launch", "braking", "speed 2.5-5 m/s", "speed 10-12.5 m/s"}
    assert table["launch"] == {"v": pytest.approx(2.0), "ax": pytest.approx(3.0)}
    assert table["braking"] == {"v": pytest.approx(4.0), "ax": pytest.approx(3.0)}
    none = comparison_page._groups(compared(residuals={"v": np.full(8, NAN), "ax": np.r_[np.full(7, NAN), 2.0]}))
    assert none["braking"] == {"v": None, "ax": pytest.approx(1.0)}
    assert "launch" not in none


def test_the_error_along_the_path_is_the_mean_square_over_a_quarter_second_to_either_side() -> None:
    """0.25 s are two steps of 0.1 s; both channels of a row count as two samples."""
    rest = {"v": np.r_[NAN, NAN, NAN, NAN, 1.0, NAN, NAN, NAN], "ax": np.r_[NAN, NAN, NAN, NAN, 8.0, NAN, NAN, NAN]}
    found = comparison_page._error(compared(residuals=rest))
    both = math.sqrt((4.0 + 16.0) / 2.0)
    assert found == pytest.approx([NAN, NAN, both, both, both, both, both, NAN], nan_ok=True)
    only = comparison_page._error(compared(residuals={**rest, "ax": np.r_[np.zeros(7), NAN]}))
    assert only[3] == pytest.approx(math.sqrt(4.0 / 6.0))  # v at one of the rows 1 to 5, ax at all five
    assert only[0] == 0.0
    coarse = comparison_page._error(compared(t=1.0 * np.arange(8.0), residuals=rest))
    assert np.isfinite(coarse).tolist() == [False] * 3 + [True] * 3 + [False] * 2  # one step at least


def test_a_position_error_is_turned_along_the_measured_heading() -> None:
    turned = compared(residuals={"x": np.full(8, 3.0), "y": np.full(8, 1.0)}, measured={"yaw": np.full(8, math.pi / 2)})
    along, across = comparison_page._track_errors(turned)
    assert along == pytest.approx(np.full(8, 1.0))
    assert across == pytest.approx(np.full(8, -3.0))
    for missing in ({"residuals": {"x": np.ones(8)}}, {"residuals": {"y": np.ones(8)}}, {"measured": {}}):
        whole: dict[str, Any] = {"residuals": {"x": np.ones(8), "y": np.ones(8)}, "measured": {"yaw": np.ones(8)}}
        assert comparison_page._track_errors(compared(**{**whole, **missing})) == (None, None)


def test_the_input_of_a_page_of_a_comparison() -> None:
    finding: Any = SimpleNamespace(code="D1", element="v", message="odd")
    found = comparison_page.page_of("a.csv", compared(not_compared={"x": "none"}), [finding], [{"signal": "v"}])
    assert (found["log"], found["model"], found["skipped"], found["not_judged"]) == ("a.csv", "M", "x: none", "")
    assert found["alignment"] == {"lag": 0.25, "coverage": 0.5}
    assert found["covered"] == "coverage 50.0 %"
    assert found["signals"]["ax"]["noise"] == 2.0
    assert found["signals"]["ax"]["rmse"] == 0.5
    assert found["warnings"] == ["D1 v: odd"]
    assert found["segments"] == pytest.approx([0.0, 0.5])
    assert set(found["residuals"]) == {"v", "ax"}
    assert found["ribbons"]["along"] == [
        ("launch", 0.0, pytest.approx(0.4)), ("braking", pytest.approx(0.6), pytest.approx(0.7)),
    ]  # fmt: skip
    assert found["ribbons"]["turns"] == []


# --- a diagnosis


def drawn(before: dict[int, Any], after: dict[int, Any] | None = None, *, channels: Any = ("v", "yaw_rate"),
          name: str = "a.csv", held: bool = False, starts: Any = (0, 5), sigma: float = 0.5) -> _Drawn:  # fmt: skip
    """Ten rows of 1 s in segments, residuals by channel, 0 elsewhere; measured is 10 times the number of the row."""
    rows = {"before": np.zeros((10, 8)), "after": np.zeros((10, 8))}
    for which, given in (("before", before), ("after", after or {})):
        for k, values in given.items():
            rows[which][:, k] = values
    measured = np.tile(10.0 * np.arange(10.0)[:, None], 8)
    ends = [*starts[1:], 10]
    experiment: Any = SimpleNamespace(
        channels=channels, sigma=np.full(8, sigma), measured=measured, log=SimpleNamespace(t=np.arange(10.0)),
        segments=SimpleNamespace(starts=np.array(starts), ends=np.array(ends)),
    )  # fmt: skip
    return _Drawn(name, held, experiment, rows["before"], rows["after"])


def test_the_level_of_a_channel_is_the_mean_square_of_what_is_known() -> None:
    one = drawn({V: [NAN] * 8 + [1.0, 2.0]})
    assert _level(one.before, one.experiment, "v") == pytest.approx((4.0 + 16.0) / 2.0)
    assert _level(np.full((10, 8), NAN), one.experiment, "v") == 0.0


def test_the_seconds_that_are_shown_are_those_in_which_most_was_taken_away() -> None:
    """Of v 4 x 9 - 1 in the second segment, of the yaw rate 16 in the first."""
    one = drawn({V: [0.0] * 5 + [3.0] * 5, RATE: [2.0] + [1.0] * 4 + [0.0] * 5}, {V: [0.0] * 5 + [1.0] * 5})
    close = _close([one], ["v", "yaw_rate"])
    assert close is not None
    assert (close["log"], close["held_out"], close["channel"], close["unit"]) == ("a.csv", False, "v", "m/s")
    assert (close["error"], close["noise"]) == (False, 0.5)
    assert close["t"].tolist() == [6.0, 7.0, 8.0, 9.0]
    assert close["measured"].tolist() == [60.0, 70.0, 80.0, 90.0]
    assert close["before"].tolist() == [57.0, 67.0, 77.0, 87.0]
    assert close["after"].tolist() == [59.0, 69.0, 79.0, 89.0]


def test_however_little_was_taken_away_it_is_shown_before_what_stayed() -> None:
    """In the second segment five times (0.36 - 0.35) / 0.25, a fifth of a sample's noise; in the first all is left."""
    one = drawn({V: [3.0] * 5 + [0.6] * 5}, {V: [3.0] * 5 + [math.sqrt(0.35)] * 5}, channels=("v",))
    close = _close([one], ["v"])
    assert close is not None
    assert close["t"].tolist() == [6.0, 7.0, 8.0, 9.0]


def test_of_several_logs_the_one_with_most_is_shown_for_eight_seconds_at_most() -> None:
    less = drawn({V: [1.0] * 10}, name="a.csv")
    more = drawn({V: [2.0] * 10}, name="b.csv", held=True, starts=(0,))
    for logs in ([less, more], [more, less]):
        close = _close(logs, ["v"])
        assert close is not None
        assert (close["log"], close["held_out"]) == ("b.csv", True)
        assert close["t"].tolist() == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]


def test_where_only_what_follows_is_off_its_error_is_shown() -> None:
    one = drawn({X: [2.0] * 5 + [3.0] * 5, V: [0.5] * 10}, channels=("x", "v"))
    close = _close([one], ["x", "v"])
    assert close is not None
    assert (close["channel"], close["error"]) == ("x", True)
    assert close["measured"].tolist() == [0.0] * 4
    assert close["before"].tolist() == [-3.0] * 4
    assert close["after"].tolist() == [0.0] * 4


def test_where_nothing_was_taken_away_the_seconds_with_the_largest_error_of_either_sign_are_shown() -> None:
    error = {V: [1.0] * 5 + [-3.0] * 5}
    close = _close([drawn(error, error, channels=("v",))], ["v"])
    assert close is not None
    assert close["t"].tolist() == [6.0, 7.0, 8.0, 9.0]


def test_where_nothing_is_off_most_of_what_is_left_is_shown_and_where_nothing_is_known_nothing() -> None:
    quiet = drawn({V: [0.5] * 5 + [0.1] * 5, RATE: [0.1] * 10}, {V: [0.5] * 5 + [0.1] * 5, RATE: [0.1] * 10})
    close = _close([quiet], ["x", "yaw_rate", "v"])
    assert close is not None
    assert (close["channel"], close["t"][0]) == ("v", 1.0)
    assert _close([drawn({}, channels=("x",))], ["x"]) is None
    assert _close([], ["v"]) is None


def test_what_is_drawn_over_time_is_what_is_or_was_off() -> None:
    """1.3 times the noise squared is quiet: 0.57 over 0.5 is 1.3, 0.58 is more."""
    one = drawn({V: [0.57] * 10, RATE: [0.58] * 10}, {V: [0.0] * 10, RATE: [0.1] * 10})
    found = _over_time(one, ["yaw_rate", "v", "ax"])
    assert (found["log"], found["held_out"], found["quiet"]) == ("a.csv", False, ["v"])
    assert list(found["rows"]) == ["yaw_rate"]
    assert found["rows"]["yaw_rate"]["before"].tolist() == [0.58] * 10
    assert found["rows"]["yaw_rate"]["after"].tolist() == [0.1] * 10
    assert found["rows"]["yaw_rate"]["noise"] == 0.5
    assert found["units"] == {"yaw_rate": "rad/s"}
    worse = drawn({V: [0.1] * 10, RATE: [0.58] * 10}, {V: [0.9] * 10})
    assert _over_time(worse, ["yaw_rate", "v"])["quiet"] == []


def test_where_all_is_quiet_the_causes_are_drawn() -> None:
    one = drawn({V: [0.1] * 10}, channels=("x", "v"))
    found = _over_time(one, ["x", "v"])
    assert (list(found["rows"]), found["quiet"]) == (["v"], [])


def test_a_position_is_drawn_along_and_across_the_car() -> None:
    """Heading a quarter turn to the left: y is along, x to the right of it."""
    one = drawn({X: [3.0] * 10, Y: [1.0] * 10}, {X: [0.0] * 10, Y: [2.0] * 10}, channels=("x", "y", "yaw"))
    one.experiment.measured[:, YAW] = math.pi / 2.0
    one.experiment.sigma[X], one.experiment.sigma[Y] = 3.0 / math.sqrt(25.0), 4.0 / math.sqrt(25.0)
    along, across = _turned(one.before, one.experiment)
    assert along == pytest.approx(np.full(10, 1.0))
    assert across == pytest.approx(np.full(10, -3.0))
    found = _over_time(one, ["x", "y", "yaw"])
    assert list(found["rows"]) == ["along", "across"]
    assert found["rows"]["along"]["after"] == pytest.approx(np.full(10, 2.0))
    assert found["rows"]["across"]["before"] == pytest.approx(np.full(10, -3.0))
    assert found["rows"]["along"]["noise"] == pytest.approx(math.sqrt((0.36 + 0.64) / 2.0))
    assert found["units"] == {"along": "m", "across": "m"}
    blind = _over_time(dataclasses.replace(one, experiment=_without(one.experiment, "yaw")), ["x", "y"])
    assert list(blind["rows"]) == ["x", "y"]


def _without(experiment: Any, name: str) -> Any:
    return SimpleNamespace(**{**vars(experiment), "channels": tuple(c for c in experiment.channels if c != name)})


def test_a_segment_begins_with_a_gap() -> None:
    values = np.arange(80.0).reshape(10, 8)
    one: Any = SimpleNamespace(residuals=lambda asked: SimpleNamespace(values=values),
                               segments=SimpleNamespace(starts=np.array([0, 5])))  # fmt: skip
    found = _rest(one, {})
    assert np.isnan(found[[0, 5]]).all()
    assert np.isfinite(np.delete(found, [0, 5], axis=0)).all()
    assert np.isfinite(values).all()


GIVEN = Step("", 21.0, {"v": 5.0, "ax": 20.0}, {"v": 0.5, "ax": 2.0}, 11.0, {"v": 0.6}, (210.0,) * 10, (110.0,) * 10,
             {("mass", "ratio"): 1.0})  # fmt: skip
AFTER = Step("drive_gain", 1.0, {"v": 1.0, "ax": 1.0}, {"v": 0.05, "ax": 0.2}, 2.0, {"v": 0.06}, (10.0,) * 10,
             (20.0,) * 10, {("drive_gain", "g"): 0.9})  # fmt: skip
GAIN = NamedEffect("drive_gain", {"g": Estimate(0.9, 0.88, 0.92, "-")}, ("mass", "mine"), 1.0, "step.xosc",
                   standing="confirmed")  # fmt: skip
FOUND = Diagnosis("AMBIGUOUS", (GAIN,), ("pitch",), (GIVEN, AFTER), {"v": 0.03}, {}, ("roll",),
                  {"full_brake": Estimate(6.0, 5.9, 6.1, "m/s^2")}, null_line=0.5)  # fmt: skip


@pytest.mark.parametrize(
    ("line", "held", "level"), [(0.5, False, 20.5), (0.5, True, 20.5), (None, False, 18.0), (None, True, None)]
)
def test_luck_is_asked_of_the_logs_fitted_on_where_it_is_not_known(
    monkeypatch: pytest.MonkeyPatch, line: float | None, held: bool, level: float | None
) -> None:
    """Of what the model as given leaves it would gain 3; without a log that was fitted on nobody knows."""
    by_luck = {True: 3.0, False: 7.0}
    monkeypatch.setattr(diagnosis_page, "candidates", lambda model, effects, ay: [])
    monkeypatch.setattr(diagnosis_page, "chance_gain", lambda target, values, tried: by_luck[values is GIVEN.values])
    one = drawn({}, held=held)
    one.experiment.model = None
    assert _null_level(dataclasses.replace(FOUND, null_line=line), [one], {}) == level


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """The values that residuals were asked for with; experiments that hold what `drawn` does."""
    seen: list[Any] = []

    def experiment(name: str, log: Any, model: Any, extra: Any) -> Any:
        found = drawn({V: [3.0] * 10}, name=name).experiment
        found.settle = lambda values: seen.append(("settled", dict(values)))

        def residuals(values: Any) -> Any:
            seen.append(dict(values))
            return SimpleNamespace(values=np.ones((10, 8)))

        found.residuals = residuals
        return found

    monkeypatch.setattr(diagnosis_page, "Experiment", experiment)
    return seen


def test_four_logs_are_drawn_with_the_model_as_given_and_with_all_that_was_found(asked: list[Any]) -> None:
    logs: Any = dict.fromkeys("abc")
    found = diagnosis_page._drawn(FOUND, logs, dict.fromkeys("de"), None, ())  # type: ignore[arg-type]
    assert [(one.name, one.held_out) for one in found] == [("a", False), ("b", False), ("c", False), ("d", True)]
    assert asked[:3] == [("settled", AFTER.values), GIVEN.values, AFTER.values]
    asked.clear()
    whole = dataclasses.replace(FOUND, values={("roll", "gain"): 0.1})
    diagnosis_page._drawn(whole, {"a": None}, {}, None, ())  # type: ignore[arg-type, dict-item]
    assert asked == [("settled", whole.values), GIVEN.values, whole.values]


def test_the_input_of_a_page_of_a_diagnosis(asked: list[Any]) -> None:
    typed = Typed("cars/car.toml", options=["--map", "m.toml"], mapping=[{"signal": "v"}])
    page = diagnosis_page.diagnosis_page(FOUND, {"a": None}, None, held_out={"b": None}, typed=typed)
    assert page["headline"].startswith("car.toml lacks drive_gain (or mass or mine: these data cannot tell)")
    assert (page["model"], page["logs"], page["held_out"], page["changed"]) == ("car.toml", ["a"], ["b"], True)
    assert page["mapping"] == [{"signal": "v"}]
    assert page["ladder"] == [{"label": "model as given", "fit": 21.0, "held_out": 11.0},
                              {"label": "+ drive_gain", "fit": 1.0, "held_out": 2.0}]  # fmt: skip
    assert page["null_line"] == pytest.approx(20.5)
    assert [signal["name"] for signal in page["signals"]] == ["ax", "v"]  # the worst first
    assert page["signals"][1] == {
        "name": "v", "unit": "m/s", "noise": 0.03, "before": 0.5, "after": 0.05, "held_before": 0.6,
        "held_after": 0.06, "chi2_before": 5.0, "chi2_after": 1.0,
    }  # fmt: skip
    assert page["signals"][0]["noise"] is page["signals"][0]["held_before"] is None
    (effect,) = page["effects"]
    assert (effect["name"], effect["apart"], effect["standing"], effect["manoeuvre"]) == (
        "drive_gain", False, "confirmed", "step.xosc",
    )  # fmt: skip
    assert effect["parameters"][0]["meaning"] == "produced over wanted acceleration"
    assert (effect["parameters"][0]["value"], effect["parameters"][0]["interval"]) == ("0.90", "0.88 to 0.92")
    assert (effect["fit"]["value"], effect["held_out"]["value"]) == (pytest.approx(1.0), pytest.approx(0.9))
    assert [rival["name"] for rival in effect["rivals"]] == ["mass", "mine"]
    assert [bool(rival["physics"]) for rival in effect["rivals"]] == [True, False]  # `mine` is not in the catalogue
    assert page["fitted_along"] == ["full_brake = 6.0 (5.9 to 6.1)"]
    assert [one["name"] for one in page["not_excited"]] == ["pitch"]
    assert page["vetoed"] == ["roll"]
    assert page["command"] == (
        "dvp extend --model cars/car.toml --add drive_gain --fit a --out car.extended.toml --map m.toml"
    )
    assert (page["plan"], page["trial"], len(page["over_time"])) == ("", "", 2)
    unknown = dataclasses.replace(FOUND, verdict="UNKNOWN", effects=())
    none = diagnosis_page.diagnosis_page(unknown, {"a": None}, None)  # type: ignore[arg-type, dict-item]
    assert (none["changed"], none["null_line"], none["model"]) == (False, None, "model.toml")
    twin = dataclasses.replace(unknown, remainder={"v": {"cruise": 0.1}})
    excused = diagnosis_page.diagnosis_page(twin, {"a": None}, None)  # type: ignore[arg-type, dict-item]
    assert (none["noise"], excused["noise"]) == ("sensor noise", "noise and remainder")


def test_what_is_indented_goes_on_with_the_line_before_it() -> None:
    assert _whole(["a", "  b", "c", "d", "    e f", " g"]) == ["a b", "c", "d e f g"]
    assert _whole(["  a", "b"]) == ["  a", "b"]
    assert _whole([]) == []
