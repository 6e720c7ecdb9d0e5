"""A bound on the harmless side of a metric alone is a warning: it passes the worse drive."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_dvp.metrics import Range
from pytest_dvp.verdicts.gate import Gate
from pytest_dvp.verdicts.harmless_side import harmless_notes
from pytest_dvp.verdicts.judging import check_gates, read_gates


@pytest.mark.parametrize(
    ("text", "side", "other"),
    [
        ('metric = "max_jerk"\nmin = 1', "min", "max = 1"),  # a harsh drive passes
        ('metric = "min_distance"\nmax = 1.5', "max", "min = 1.5"),  # a contact, 0 m, passes
        ('metric = "mncc"\nsignal = "v"\nbetween = ["dt", "rw"]\nmax = 0.9', "max", "min = 0.9"),
    ],
)
def test_a_lone_bound_on_the_harmless_side_is_a_warning(text: str, side: str, other: str, tmp_path: Path) -> None:
    file = tmp_path / "a.gates.toml"
    file.write_text(f"[[gate]]\n{text}\n", encoding="utf-8")
    (found,) = check_gates(file)
    assert (found.code, found.severity, found.line) == ("dvp.gates.harmless_side", "warning", 1)
    assert found.element == f"gate.{side}"
    assert found.message.endswith(f"(did you mean {other}?)")
    (note,) = harmless_notes(read_gates(file).gates)  # the file is read, and its run says the same
    assert note.startswith(f"one-sided gate: {file}:1: ")
    assert note.endswith(found.message)


@pytest.mark.parametrize(
    "gate",
    [
        Gate("max_jerk", max=4.0),
        Gate("max_jerk", min=1.0, max=4.0),
        Gate("min_distance", min=0.5),
        Gate("event_started", min=1.0, options={"event": "CutIn"}),  # one event must happen, another one must not
        Gate("lag", min=-0.3, options={"signal": "v"}, between=("dt", "rw")),
        Gate("max_jerk", min=1.0, only_with={}),  # a bound of clean drives
        Gate("no_metric", min=1.0),
    ],
)
def test_other_gates_say_nothing(gate: Gate) -> None:
    assert harmless_notes([gate]) == []


def test_two_gates_that_bound_both_sides_together_say_nothing() -> None:
    low, high = Gate("max_jerk", min=0.1), Gate("max_jerk", max=3.0)
    assert harmless_notes([low, high]) == []
    elsewhere = [Gate("max_jerk", max=3.0, stages=("rw",)), Gate("max_jerk", max=3.0, options={"cutoff": 2.0})]
    assert len(harmless_notes([low, *elsewhere])) == 1


@pytest.mark.parametrize(
    ("limits", "inside", "outside", "told"),
    [
        (Range(0.0, above=True), (1e-9, 5.0), (0.0, -1.0), "> 0"),
        (Range(0.0), (0.0, 5.0), (-1e-9,), ">= 0"),
        (Range(0.5, 2.0), (0.5, 2.0), (0.49, 2.01), ">= 0.5 and <= 2"),
        (Range(high=2.0), (-9.0, 2.0), (2.1,), "<= 2"),
    ],
)
def test_a_range_has_ends(limits: Range, inside: tuple[float, ...], outside: tuple[float, ...], told: str) -> None:
    assert all(map(limits.holds, inside))
    assert not any(map(limits.holds, outside))
    assert str(limits) == told
