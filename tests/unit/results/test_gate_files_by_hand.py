"""Gate files by hand: each mistake with its line and its text, and gates that ask the same."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from pytest_dvp.verdicts.equal_gates import repeated
from pytest_dvp.verdicts.gate import STAGES, Gate, GateError
from pytest_dvp.verdicts.gate_file import check_gates, read_gates
from pytest_dvp.verdicts.gate_file_lines import locate_lines

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
