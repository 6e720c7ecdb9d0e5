"""Gates by hand: margin, share and words of a verdict, and each mistake of a gate file with its line and its text."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from results_logs import log_of, times

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import LogEvent
from pytest_dvp.metrics.metric import MetricValue
from pytest_dvp.verdicts import judging
from pytest_dvp.verdicts.clean_gates import applies
from pytest_dvp.verdicts.equal_gates import repeated
from pytest_dvp.verdicts.gate import STAGES, Gate, GateError, GateFile
from pytest_dvp.verdicts.gate_file import check_gates, read_gates
from pytest_dvp.verdicts.gate_file_lines import locate_lines
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


# --- a gate file

GOOD = """\
[task]
start = { road = "1", lane = -1, s = 0 }
lane = -1

[[gate]]
metric = "max_jerk"
max = 2

[[gate]]
metric = "max_yaw_rate"
min = -1.5
max = 3.0
stages = ["rw", "dt"]
requirement = "R-1"
"""


def test_a_gate_file_as_data(tmp_path: Path) -> None:
    file = tmp_path / "gates.toml"
    file.write_text(GOOD)
    found = read_gates(file)
    assert found.task is not None
    assert (found.task.start, found.task.goal, found.task.lane) == (("1", -1, 0.0), None, -1)
    assert found.gates == (
        Gate("max_jerk", 2.0, None, STAGES, None, {}, str(file), 5),
        Gate("max_yaw_rate", 3.0, -1.5, ("rw", "dt"), None, {}, str(file), 9, requirement="R-1"),
    )
    assert found.traffic is None


@pytest.mark.parametrize(
    ("text", "code", "line", "element", "message"),
    [
        ("", "no_gate", 1, "gate", "no [[gate]]: a file without gates judges nothing"),
        ("gate = 3", "not_a_table", 1, "gate", "gates are written as [[gate]] tables"),
        ("task = 3\n" + GOOD[GOOD.index("[[") :], "not_a_table", 1, "task", "[task] must be a table"),
        (GOOD.replace("lane = -1\n", "lane = 0\n"), "value", 3, "task.lane",
         "lane must be a lane id; found '0'; allowed: whole number except 0"),
        (GOOD.replace("lane = -1\n", "lane = true\n"), "value", 3, "task.lane",
         "lane must be a lane id; found 'True'; allowed: whole number except 0"),
        (GOOD.replace("lane = -1, s", "lane = 0, s"), "value", 2, "task.start.lane",
         "lane must be a lane id; found '0'; allowed: whole number except 0"),
        (GOOD.replace("s = 0 }", "s = -0.1 }"), "value", 2, "task.start.s",
         "s must be a distance; found '-0.1'; allowed: finite, >= 0 [m]"),
        (GOOD.replace("s = 0 }", "s = inf }"), "value", 2, "task.start.s",
         "s must be a distance; found 'inf'; allowed: finite, >= 0 [m]"),
        (GOOD.replace('road = "1"', "road = 1"), "value", 2, "task.start.road",
         "road must be an id in quotes; found '1'"),
        (GOOD.replace(", s = 0 }", " }"), "place", 2, "task.start",
         "start must be a place; allowed: { road = \"1\", lane = -1, s = 420.0 }"),
        (GOOD.replace("max = 2\n", "max = nan\n"), "bound", 7, "gate[1].max",
         "max must be a finite number; found 'nan'"),
        (GOOD.replace("max = 2\n", "max = true\n"), "bound", 7, "gate[1].max",
         "max must be a finite number; found 'True'"),
        (GOOD.replace("max = 2\n", ""), "no_bound", 5, "gate[1]", "a gate needs a bound; allowed: max, min or both"),
        (GOOD.replace("min = -1.5", "min = 3.5"), "min_over_max", 11, "gate[2].min", "min 3.5 is greater than max 3"),
        (GOOD.replace('"rw", "dt"', ""), "stages", 13, "gate[2].stages",
         "stages must be a list of stages; allowed: dt, pe, rw"),
        (GOOD.replace('stages = ["rw", "dt"]', 'between = ["rw", "rw"]'), "between", 13, "gate[2].between",
         "between needs two different stages"),
        (GOOD.replace('"R-1"', '" "'), "requirement", 14, "gate[2].requirement",
         "requirement is empty: name one, or leave the key out"),
        (GOOD.replace('metric = "max_jerk"\n', ""), "no_metric", 5, "gate[1]",
         'a gate needs a metric: metric = "collision" (or model = "car.toml")'),
        (GOOD + '[traffic]\nnet = "a.net.xml"\n', "value", 15, "traffic.routes",
         "routes must be the name of a file beside this one"),
        (GOOD + '[traffic]\nnet = ".."\nroutes = "r"\n', "value", 15, "traffic.net",
         "net must be the name of a file beside this one"),
        (GOOD + '[traffic]\nnet = "a/b"\nroutes = "r"\n', "value", 15, "traffic.net",
         "net must be the name of a file beside this one"),
    ],
)  # fmt: skip
def test_each_mistake_of_a_gate_file_has_its_line(
    tmp_path: Path, text: str, code: str, line: int, element: str, message: str
) -> None:
    file = tmp_path / "gates.toml"
    file.write_text(text)
    first = check_gates(file)[0]
    assert (first.code, first.severity, first.line, first.element) == (f"dvp.gates.{code}", "error", line, element)
    assert first.message == message
    with pytest.raises(GateError) as caught:
        read_gates(file)
    assert (caught.value.line, caught.value.code) == (line, f"dvp.gates.{code}")


def test_both_bounds_may_be_equal(tmp_path: Path) -> None:
    file = tmp_path / "gates.toml"
    file.write_text(GOOD.replace("min = -1.5", "min = 3"))
    assert check_gates(file) == ()


def test_one_mistake_is_told_alone(tmp_path: Path) -> None:
    file = tmp_path / "gates.toml"
    file.write_text(GOOD.replace("max = 2\n", "max = nan\n"))
    with pytest.raises(GateError) as caught:
        read_gates(file)
    assert str(caught.value) == f"{file}:7: error dvp.gates.bound gate[1].max: max must be a finite number; found 'nan'"


def test_all_mistakes_are_told_and_counted(tmp_path: Path) -> None:
    file = tmp_path / "gates.toml"
    file.write_text(GOOD.replace("max = 2\n", "max = nan\n").replace("min = -1.5", "min = nan"))
    with pytest.raises(GateError) as caught:
        read_gates(file)
    assert len(caught.value.findings) == 2
    assert str(caught.value).endswith(f"(and 1 more: dvp check {file})")


def test_background_traffic_lies_beside_the_gate_file(tmp_path: Path) -> None:
    file = tmp_path / "gates.toml"
    file.write_text(GOOD + '[traffic]\nnet = "a-1.net.xml"\nroutes = "r"\n')
    traffic = read_gates(file).traffic
    assert traffic is not None
    assert (traffic.net, traffic.routes) == ("a-1.net.xml", "r")


@pytest.mark.parametrize(
    ("text", "top", "gates"),
    [
        ("a = 1\n\n# b = 2\nc = 3", {"a": 1, "c": 4}, []),
        ("a = [\n1,\n2]\nb = 1", {"a": 1, "b": 4}, []),
        ('a = """\nb = 1\n"""\nc = 1', {"a": 1, "c": 4}, []),
        ("a = \"x # ] [\"\nb = '\\'\nc = 1", {"a": 1, "b": 2, "c": 3}, []),
        ('a = "\\""\nb = 1', {"a": 1, "b": 2}, []),
        ("a = [ # ]\n1]\nb = 1", {"a": 1, "b": 3}, []),
        ("[[gate]]\nx = 1\n[[gate]]\ny.z = 1\ny.w = 2", {"gate": 1}, [(1, {"x": 2}), (3, {"y": 4})]),
        ("[[gate]]\n[gate.o]\nq = 1\n[clean.max]", {"gate": 1, "clean": 4}, [(1, {"o": 2})]),
    ],
)
def test_lines_of_tables_and_keys(text: str, top: dict[str, int], gates: list[Any]) -> None:
    found = locate_lines(text)
    assert found.top == top
    assert found.gates == gates


# --- gates of one file that ask the same


@pytest.mark.parametrize(
    ("gates", "told"),
    [
        (({"max": 1.0}, {"max": 1.0}), [("equal", 2)]),
        (({"max": 1.0}, {"max": 2.0}), [("never_decides", 2)]),
        (({"max": 2.0}, {"max": 1.0}), [("never_decides", 1)]),
        (({"max": 2.0}, {"min": 1.0}), []),
        (({"max": 2.0, "min": 0.0}, {"min": 0.0}), [("never_decides", 2)]),
        (({"min": 1.0}, {"min": 2.0}), [("never_decides", 1)]),
        (({"max": 1.0, "stages": ("dt",)}, {"max": 2.0}), []),
        (({"max": 1.0}, {"max": 2.0, "stages": ("dt",)}), [("never_decides", 2)]),
        (({"max": 1.0, "stages": ("dt",)}, {"max": 1.0, "stages": ("rw",)}), []),
        (({"max": 1.0, "metric": "max_yaw_rate"}, {"max": 1.0}, {"max": 1.0}), [("equal", 3)]),
        (({"max": 1.0, "stages": ("dt",)}, {"max": 1.0, "stages": ("rw",)}, {"max": 1.0, "stages": ("dt",)}),
         [("equal", 3)]),
    ],
)  # fmt: skip
def test_gates_that_ask_twice(gates: tuple[dict[str, Any], ...], told: list[tuple[str, int]]) -> None:
    made = [Gate(**{"metric": "max_jerk", "line": n, **gate}) for n, gate in enumerate(gates, 1)]
    assert [(f.code.removeprefix("dvp.gates."), f.line) for f in repeated(made)] == told


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
