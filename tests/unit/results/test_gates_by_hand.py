"""Gates by hand: margin, share and words of a verdict, which gates are judged, and what a test lets be."""

from __future__ import annotations

import math
from typing import Any

import pytest
from results_logs import log_of, times

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import LogEvent
from pytest_dvp.metrics.metric import MetricValue
from pytest_dvp.verdicts import judging
from pytest_dvp.verdicts.clean_gates import applies
from pytest_dvp.verdicts.gate import Gate, GateFile
from pytest_dvp.verdicts.no_evidence import no_evidence
from pytest_dvp.verdicts.requirement import wrong_requirement
from pytest_dvp.verdicts.silent_events import check_optional, missed, storyboard_verdict, without_optional

# --- margin and share


@pytest.mark.parametrize(
    ("bounds", "value", "expected"),
    [
        ({"max": 2.0}, 2.0, (0.0, 2.0, "<=")),
        ({"max": 2.0}, 2.5, (-0.5, 2.0, ">")),
        ({"min": 2.0}, 2.0, (0.0, 2.0, ">=")),
        ({"min": 2.0}, 1.5, (-0.5, 2.0, "<")),
        ({"min": 0.0, "max": 4.0}, 1.0, (1.0, 0.0, ">=")),
        ({"min": 0.0, "max": 4.0}, 3.5, (0.5, 4.0, "<=")),
        ({"min": 0.0, "max": 4.0}, -1.0, (-1.0, 0.0, "<")),
        ({"max_difference": 0.25}, 0.25, (0.0, 0.25, "<=")),
        ({"max_difference": 0.25}, 0.5, (-0.25, 0.25, ">")),
    ],
)
def test_the_margin_is_to_the_nearest_bound(bounds: Any, value: float, expected: tuple[float, float, str]) -> None:
    assert judging._margin(Gate("max_jerk", **bounds), value) == expected


@pytest.mark.parametrize(
    ("gate", "value", "bound", "share"),
    [
        (Gate("max_jerk", max=2.0), 1.0, 2.0, 0.5),
        (Gate("max_jerk", max=2.0), 3.0, 2.0, 1.5),
        (Gate("max_jerk", max=0.0), 1.0, 0.0, None),
        (Gate("completion_time", min=2.0), 4.0, 2.0, 0.5),  # a lower bound, passed by a factor of 2
        (Gate("completion_time", min=2.0), 1.0, 2.0, 2.0),
        (Gate("completion_time", min=2.0), 0.0, 2.0, None),
        (Gate("completion_time", min=-2.0), -1.0, -2.0, 0.5),
        (Gate("completion_time", min=2.0, max=2.0), 1.0, 2.0, 0.5),  # both bounds: counted as the upper
        (Gate("max_jerk", max_difference=0.5, between=("dt", "rw")), 0.125, 0.5, 0.25),
    ],
)
def test_the_share_of_what_a_bound_allows(gate: Gate, value: float, bound: float, share: float | None) -> None:
    assert judging._used(gate, value, bound) == share


# --- words of a verdict


@pytest.mark.parametrize(
    ("value", "bound", "unit", "texts"),
    [
        (1.0, 0.0, "-", ("1", "0")),
        (1.5, 2.0, "-", ("1.50", "2.00")),
        (1.0, 2.0, "m", ("1.00", "2.00")),
        (2.001, 2.0, "m", ("2.001", "2.000")),  # must not read like its bound
        (2.0, 2.0, "m", ("2.00", "2.00")),
        (0.001, 0.002, "m", ("0.001", "0.002")),  # a bound of 0.002 must not read like 0
        (-0.5, 0.0, "m", ("-0.50", "0.00")),
        (1.00000000002, 1.0, "m", ("1", "1")),  # nine digits do not keep these apart
    ],
)
def test_two_numbers_have_the_decimals_that_keep_them_apart(
    value: float, bound: float, unit: str, texts: tuple[str, str]
) -> None:
    assert judging._pair(value, bound, unit) == texts


def test_a_verdict_in_its_words() -> None:
    value = MetricValue("max_jerk", 2.5, "m/s^3", 1.234, "car\x1b", True, "", None, {}, "")
    found = judging._verdict(Gate("max_jerk", max=2.0, file="a.toml", line=7, requirement="R1"), "FAIL", value, "")
    assert found.gate == "max_jerk <= 2.00 m/s^3"
    assert found.short == "max_jerk 2.50 m/s^3 > 2.00 at t=1.23 s (car?)"
    assert found.message == "max_jerk 2.50 m/s^3 > 2.00 at t=1.23 s (car?), margin -0.50 m/s^3, gate a.toml:7"
    assert (found.value, found.bound, found.margin, found.used) == (2.5, 2.0, -0.5, 1.25)
    assert (found.reason, found.requirement, found.clean, found.line) == ("", "R1", False, 7)


@pytest.mark.parametrize(("value", "margin"), [(1.996, "0.004"), (2.0, "0.00"), (1.5, "0.50"), (2.5, "-0.50")])
def test_a_margin_has_the_decimals_that_tell_it_from_none(value: float, margin: str) -> None:
    found = judging._verdict(
        Gate("max_jerk", max=2.0), "PASS", MetricValue("max_jerk", value, "m", None, "", True, "", None, {}, ""), ""
    )
    assert found.message.endswith(f", margin {margin} m, default gate")


def test_a_verdict_without_a_value_tells_why() -> None:
    found = judging._verdict(Gate("max_jerk", min=1.0, max=2.0), "INCONCLUSIVE", None, "no\nlog")
    assert found.gate == "max_jerk >= 1.00 and <= 2.00"
    assert found.short == "max_jerk INCONCLUSIVE: no?log"
    assert found.message == "max_jerk INCONCLUSIVE: no?log, default gate"
    assert (found.value, found.bound, found.margin, found.used, found.t) == (None,) * 5
    assert (found.reason, found.unit, found.object) == ("no?log", "", "")


@pytest.mark.parametrize(
    ("gate", "name"),
    [
        (Gate("max_jerk"), "max_jerk"),
        (Gate("max_jerk", between=("dt", "rw"), max_difference=1.0), "max_jerk difference"),
        (Gate("rmse", between=("dt", "rw"), options={"signal": "v"}), "rmse(v)"),
        (Gate("open_loop_error", options={"signal": "v", "model": "a/b/car.toml"}, key="rmse"), "rmse(v, car.toml)"),
        (Gate("open_loop_error", options={"model": "car.toml"}), "open_loop_error(, car.toml)"),
        (Gate("recall", options={"reach": 40.0, "of": "car"}, only_with={}), "recall(reach=40, of=car)"),
        (Gate("recall", only_with={}), "recall"),
    ],
)
def test_what_a_gate_is_called(gate: Gate, name: str) -> None:
    assert judging._name(gate) == name


@pytest.mark.parametrize(
    ("statuses", "worst"),
    [
        ((), "INCONCLUSIVE"),
        (("PASS",), "PASS"),
        (("PASS", "INCONCLUSIVE"), "INCONCLUSIVE"),
        (("INCONCLUSIVE", "FAIL", "PASS"), "FAIL"),
        (("FAIL", "ERROR"), "ERROR"),
    ],
)
def test_the_worst_of_verdicts(statuses: tuple[Any, ...], worst: str) -> None:
    assert judging.overall([judging._verdict(Gate("max_jerk"), status, None, "") for status in statuses]) == worst


def reached(after: float) -> Log:
    """A log of 10 s whose ego reaches its goal after a time [s]."""
    return log_of(10.0, events=(LogEvent(after, "goal", ""),))


@pytest.mark.parametrize(
    ("bounds", "status"),
    [
        ({"max": 5.0}, "PASS"),
        ({"max": math.nextafter(5.0, 0.0)}, "FAIL"),
        ({"min": 5.0}, "PASS"),
        ({"min": math.nextafter(5.0, 9.0)}, "FAIL"),
    ],
)
def test_a_bound_is_kept_at_its_value_and_broken_beyond_it(bounds: Any, status: str) -> None:
    assert judging._judge(Gate("completion_time", **bounds), reached(5.0)).status == status


def test_a_difference_between_stages_has_no_sign_and_tells_both() -> None:
    gate = Gate("completion_time", max_difference=1.0, between=("dt", "rw"))
    soon, late = reached(4.0), reached(5.5)
    found = [judging._evaluate(gate, *pair) for pair in ((soon, late), (late, soon))]
    assert [(one.value, one.t, one.object) for one in found] == [
        (1.5, None, "dt 4.00, rw 5.50"),
        (1.5, None, "dt 5.50, rw 4.00"),
    ]


@pytest.mark.parametrize(
    ("given", "metrics"),
    [
        ((), []),
        ((Gate("max_jerk", max=1.0, stages=("rw",)),), []),
        ((Gate("max_jerk", max=1.0, stages=("dt",)),), ["max_jerk"]),
        ((Gate("max_jerk", between=("dt", "rw")),), ["collision", "road_departure", "scenario_ended"]),
        ((Gate("max_jerk", between=("dt", "rw")), Gate("max_yaw_rate", max=1.0)), ["max_yaw_rate"]),
    ],
)
def test_which_gates_are_judged_on_a_log(given: tuple[Gate, ...], metrics: list[str]) -> None:
    log = log_of(1.0)
    assert [gate.metric for gate in judging._here(given, log)] == metrics
    assert [gate.metric for gate in judging._here(GateFile(None, given), log)] == metrics


def test_a_surrogate_of_the_road_is_judged_by_the_gates_of_the_road() -> None:
    gates = [Gate("max_yaw_rate", max=1.0, stages=("rw",)), Gate("max_jerk", max=1.0, stages=("dt",))]
    assert [gate.metric for gate in judging._here(gates, log_of(1.0, meta={"stage": "rw-surrogate"}))] == [
        "max_yaw_rate"
    ]


def test_nothing_to_judge_is_one_verdict_that_says_so() -> None:
    (alone,) = judging.judge([], log_of(1.0))
    assert (alone.status, alone.message) == ("INCONCLUSIVE", "no gate applies to stage dt: nothing was judged")
    (pair,) = judging.judge_between([], ("dt", "rw"), {})
    assert (pair.status, pair.short) == ("INCONCLUSIVE", "no gate is between dt and rw: nothing was judged")
    gates = [Gate("max_yaw_rate", max_difference=1.0, between=("dt", "rw"))]
    (lacking,) = judging.judge_between(gates, ("dt", "rw"), {"dt": log_of(1.0)})
    assert lacking.reason == "no log of stage rw to compare with"
    (told,) = judging.judge_between(gates, ("dt", "rw"), {"rw": log_of(1.0)}, {"dt": "run it", "rw": "?"})
    assert told.reason == "run it"


@pytest.mark.parametrize(
    ("lasts", "status"), [(4.0, "INCONCLUSIVE"), (5.0, "PASS"), (20.0, "PASS"), (21.0, "INCONCLUSIVE")]
)
def test_a_drive_that_ended_before_half_of_the_other_passes_no_gate(lasts: float, status: str) -> None:
    """The other lasted 10 s. Nobody was hit on either, but of most of the test one of them tells nothing."""
    gate = Gate("max_yaw_rate", max_difference=0.1, between=("dt", "rw"))
    (found,) = judging.judge_between([gate], ("dt", "rw"), {"dt": log_of(10.0), "rw": log_of(lasts)})
    assert found.status == status
    if lasts == 4.0:
        assert "stage rw ended after 4.0 s, stage dt lasted 10.0 s" in found.short
    turning = log_of(lasts, columns={"yaw": 0.5 * times(lasts), "yaw_rate": 0.5})
    (missed,) = judging.judge_between([gate], ("dt", "rw"), {"dt": log_of(10.0), "rw": turning})
    assert missed.status == "FAIL"


def test_pairs_of_stages_are_told_once_and_in_order() -> None:
    pairs = [("pe", "rw"), None, ("dt", "rw"), ("pe", "rw")]
    assert judging.pairs_of([Gate("max_jerk", between=pair) for pair in pairs]) == [("pe", "rw"), ("dt", "rw")]


# --- ids, clean bounds, evidence, events


@pytest.mark.parametrize(
    ("value", "wrong"),
    [
        ("x" * 200, ""),
        ("x" * 201, "requirement must be one line of at most 200 printable characters"),
        ("a\nb", "requirement must be one line of at most 200 printable characters"),
        (7, "requirement must be an id in quotes, requirement = \"SR-12\"; found '7'"),
    ],
)
def test_ids_of_requirements(value: object, wrong: str) -> None:
    assert wrong_requirement(value) == wrong


@pytest.mark.parametrize(
    ("meta", "column", "expected"),
    [
        ({"parameters": {"v": 5.5}}, 1.0, True),
        ({"parameters": {"v": "5.5"}}, 1.0, True),
        ({"parameters": {"v": 5.5 * (1.0 + 5e-10)}}, 1.0, True),
        ({"parameters": {"v": 5.5 * (1.0 + 2e-9)}}, 1.0, False),
        ({"parameters": {"v": "fast"}}, 1.0, False),
        ({"parameters": {}}, 1.0, False),
        ({}, 1.0, False),
        ({"parameters": {"v": 5.5}}, math.nan, False),
        ({"parameters": {"v": 5.5}}, None, False),
        ({"parameters": {"v": 5.5}, "S": 2}, 1.0, False),
    ],
)
def test_where_a_clean_bound_applies(meta: dict[str, Any], column: float | None, expected: bool) -> None:
    log = log_of(0.1, columns={} if column is None else {"ads.sigma": column}, meta=meta)
    assert applies(Gate("max_jerk", max=1.0, only_if_logged="ads.sigma", only_with={"v": 5.5}), log) is expected
    assert applies(Gate("max_jerk", max=1.0, only_if_logged="ads.sigma"), log)


@pytest.mark.parametrize(
    ("model", "told"),
    [
        (None, ""),
        ({"scaled": False, "file": "a.toml"}, ""),
        (
            {"scaled": True, "file": "a.toml", "to": "van", "mass": 2000.0},
            "what drove is not a.toml, but that scaled to the car of the scenario, van (mass 2000 kg); "
            "one of both has a wrong wheelbase or mass",
        ),
        (
            {"scaled": True, "wheelbase": 2.71, "mass": 1500.5},
            "what drove is not the model, but that scaled to the car of the scenario,  (wheelbase 2.71 m, "
            "mass 1500.5 kg); one of both has a wrong wheelbase or mass",
        ),
    ],
)
def test_a_scaled_twin_is_no_evidence(model: Any, told: str) -> None:
    assert no_evidence(log_of(0.1, meta={} if model is None else {"model": model})) == told


@pytest.mark.parametrize(
    ("silent", "count", "short"),
    [
        (["a"], 5, "storyboard INCONCLUSIVE: event 'a' never fired"),
        (["a", "b"], 5, "storyboard INCONCLUSIVE: 2 of 5 events never fired: 'a', 'b'"),
        (["a", "b", "c"], 3, "storyboard INCONCLUSIVE: 3 of 3 events never fired: 'a', 'b', 'c'"),
        (["a", "b", "c", "d"], 4, "storyboard INCONCLUSIVE: 4 of 4 events never fired: 'a', 'b', 'c', ..."),
    ],
)
def test_events_that_never_fired(silent: list[str], count: int, short: str) -> None:
    assert storyboard_verdict(silent, count)["short"] == short


def counted(value: float, bound: float) -> dict[str, Any]:
    return {"metric": "events_fired", "gate": "g", "status": "INCONCLUSIVE", "value": value, "bound": bound}


@pytest.mark.parametrize(
    ("value", "bound", "optional", "status", "margin", "left"),
    [
        (3.0, 1.0, ["S::a"], "INCONCLUSIVE", -1.0, 2.0),
        (3.0, 2.0, ["S::a"], "PASS", 0.0, 2.0),
        (3.0, 1.0, ["S::a", "S::b"], "PASS", 0.0, 1.0),
        (3.0, 2.0, ["S::a", "S::b"], "PASS", 1.0, 1.0),
    ],
)
def test_events_that_a_test_lets_be(
    value: float, bound: float, optional: list[str], status: str, margin: float, left: float
) -> None:
    names = ["S::a", "S::b", "S::c"]
    result = {"never_fired": names, "events": names, "verdicts": [counted(value, bound)], "status": "INCONCLUSIVE"}
    (found,) = without_optional(result, optional)["verdicts"]
    assert (found["status"], found["margin"], found["value"]) == (status, margin, left)
    if status == "PASS":
        assert found["message"] == f"events_fired {left:.0f} <= {bound:.0f}, margin {margin:.0f}"
        assert found["object"] == ""
    else:
        assert found["object"] == "S::b"
    assert without_optional(result, []) == result


def test_missed_events_are_told_unless_a_gate_decides() -> None:
    told = missed({"never_fired": ["a"], "events": ["a", "b"], "verdicts": []})
    assert told is not None
    assert told["short"] == "storyboard INCONCLUSIVE: event 'a' never fired"
    assert missed({"never_fired": [], "verdicts": []}) is None
    assert missed({"never_fired": ["a"], "verdicts": [counted(1.0, 1.0)]}) is None


def test_an_optional_event_must_be_one_of_the_storyboard() -> None:
    check_optional(["S::a"], ["S::a"])
    with pytest.raises(
        Exception, match=r"optional_events: found 'x', expected a list of names: optional_events=\['x'\]"
    ):
        check_optional("x", ["x"])
    with pytest.raises(Exception, match="no storyboard event 'brake'; it has none"):
        check_optional(["brake"], [])
    with pytest.raises(Exception, match="no storyboard event 'brakes'; did you mean 'brake'"):
        check_optional(["brakes"], ["S::brake"])
