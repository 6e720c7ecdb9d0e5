"""What a run says of itself, line by line, and which names of signals a gate may use."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from openscenario.findings import nearest
from pytest_dvp.verdicts.gate import Gate, GateFile
from pytest_dvp.verdicts.gate_references import unknown_names
from pytest_dvp.verdicts.gate_signal import OF_MODEL, wrong_signal
from pytest_dvp.verdicts.result_text import (
    asked_verdicts,
    condition_of,
    conditions,
    failure,
    gathered,
    on_condition,
    page_of,
    undecided,
    without_clean,
)
from pytest_dvp.verdicts.stage_table import Cell


def verdict(metric: str, status: str = "PASS", **more: Any) -> dict[str, Any]:
    usual = {"gate": f"{metric} <= 1", "short": f"{metric} short", "message": f"{metric} message", "reason": "",
             "name": metric, "file": "g.toml", "line": 3, "clean": False, "value": 1.0, "used": 0.5}  # fmt: skip
    return {"metric": metric, "status": status, "margin": 0.0, "bound": 1.0, **usual, **more}


def result(*verdicts: dict[str, Any], **more: Any) -> dict[str, Any]:
    usual = {"scenario": "a.xosc", "stage": "dt", "seed": 3, "replay": "dvp run a.xosc", "status": "FAIL"}
    return {**usual, "verdicts": list(verdicts), **more}


def test_a_failure_in_full() -> None:
    told = failure(
        result(
            verdict("b"),
            verdict("a", "FAIL"),
            verdict("c", clean=True),
            error="one\ntwo",
            notes=["not judged: x", "guard: y", "idle talk", "dt and rw differ in seed"],
            explanation=["it lacks drag"],
            why=["dvp diagnose z"],
            ended="timeout",
            simulated=12.345,
            folder="runs/7",
        )
    )
    assert told is not None
    assert told.split("\n") == [
        "a short",
        "  one",
        "  two",
        "  FAIL a message",
        "  it lacks drag",
        "  not judged: x",
        "  guard: y",
        "  dt and rw differ in seed",
        "  1 of 2 gates passed, 1 of 1 bounds of clean drives; a.xosc, stage dt, seed 3",
        "  ended by timeout at t=12.35 s",
        "  report: runs/7/report.html",
        "  what the twin lacks: dvp diagnose z",
        "  replay: dvp run a.xosc",
    ]


def test_what_nobody_asked_for_fails_no_choice_of_gates() -> None:
    """And a run that is not PASS is told, even where no verdict says why."""
    run = result(verdict("a"), verdict("b", "FAIL"))
    assert failure(run, ["a"]) is None
    assert str(failure(run, ["b"])).startswith("b short\n")
    assert str(failure(run)).startswith("b short\n")
    assert str(failure(run, ["a", "c"])).startswith("INCONCLUSIVE: no gate on c")
    assert str(failure(result(verdict("a")))).startswith("FAIL: no gate was judged")
    assert failure(result(verdict("a"), status="PASS")) is None
    # Events that all fired, of which no choice gets rid, are no gate that somebody has chosen.
    events = result(verdict("events_fired"), status="PASS")
    assert failure(events) is failure(events, ["events_fired"]) is None
    assert str(failure(events, [])).startswith("INCONCLUSIVE: no gate was judged")


def test_a_short_failure_says_no_more_than_it_has() -> None:
    assert failure(result(verdict("a", "FAIL"), verdict("b", "FAIL"))) == (
        "a short\n  FAIL a message\n  FAIL b message\n  0 of 2 gates passed; a.xosc, stage dt, seed 3\n"
        "  replay: dvp run a.xosc"
    )


@pytest.mark.parametrize(("count", "shown"), [(3, 3), (4, 3), (5, 3)])
def test_few_bounds_of_clean_drives_are_named(count: int, shown: int) -> None:
    told = failure(result(*(verdict(f"m{k}", "FAIL", clean=True) for k in range(count))))
    assert told is not None
    assert told.count("  FAIL m") == shown
    more = f"  ... and {count - 3} more bounds that clean drives keep"
    assert (more in told) == (count > 3)
    assert f"0 of 0 gates passed, 0 of {count} bounds of clean drives;" in told


@pytest.mark.parametrize(
    ("given", "metrics", "first"),
    [
        (result(verdict("a"), status="PASS"), None, None),
        (result(status="INCONCLUSIVE"), None, "INCONCLUSIVE: no gate was judged, and nothing judged is never a PASS"),
        (result(verdict("a"), verdict("b", "FAIL")), ["a"], None),
        (result(verdict("collision")), ["colision"],
         "INCONCLUSIVE: no gate on colision; did you mean 'collision' for 'colision'?"),
        (result(verdict("a"), metrics={"b": 1.0}), ["b"], "INCONCLUSIVE: no gate on b"),
        (result(verdict("a")), ["a", "b"], "INCONCLUSIVE: no gate on b"),
    ],
)  # fmt: skip
def test_the_first_line_of_a_run(given: Any, metrics: list[str] | None, first: str | None) -> None:
    told = failure(given, metrics)
    assert (None if told is None else told.split("\n")[0]) == first


@pytest.mark.parametrize(
    ("statuses", "metrics", "expected"),
    [
        (("PASS", "INCONCLUSIVE"), None, True),
        (("PASS", "PASS"), None, False),
        (("FAIL", "INCONCLUSIVE"), None, False),
        (("FAIL", "INCONCLUSIVE"), ["m1"], True),
        (("FAIL", "INCONCLUSIVE"), ["m1", "m2"], False),
        (("INCONCLUSIVE", "ERROR"), None, False),
    ],
)
def test_what_is_undecided(statuses: tuple[str, ...], metrics: list[str] | None, expected: bool) -> None:
    given = result(*(verdict(f"m{k}", status) for k, status in enumerate(statuses)))
    assert undecided(given, metrics) is expected


def test_no_choice_leaves_out_a_run_that_broke() -> None:
    broke = verdict("", "ERROR", gate="run")
    given = result(broke, verdict("a"), verdict("b"))
    assert asked_verdicts(given, ["a"]) == [broke, verdict("a")]
    assert asked_verdicts(given, ["b <= 1"]) == [broke, verdict("b")]
    assert asked_verdicts(given, []) == [broke]


@pytest.mark.parametrize(
    ("count", "short"),
    [
        (1, "m0 short"),
        (2, "m0, m1 INCONCLUSIVE: dark"),
        (3, "m0, m1, m2 INCONCLUSIVE: dark"),
        (4, "4 gates (m0, m1, m2, ...) INCONCLUSIVE: dark"),
    ],
)
def test_verdicts_of_one_reason_are_one(count: int, short: str) -> None:
    alike = [verdict(f"m{k}", "INCONCLUSIVE", reason="dark", line=9 - k) for k in range(count)]
    found = gathered([verdict("a", "FAIL"), *alike, verdict("z", "INCONCLUSIVE", reason="wet")])
    assert [v["short"] for v in found] == ["a short", short, "z short"]
    place = f"{short}; the first is gate g.toml:{9 - (count - 1)}" if count > 1 else "m0 message"
    assert found[1]["message"] == place


def test_default_gates_of_one_reason_have_no_line() -> None:
    alike = [verdict(f"m{k}", "INCONCLUSIVE", reason="dark", line=None, file="", name="") for k in range(2)]
    assert gathered(alike)[0]["message"] == "m0, m1 INCONCLUSIVE: dark"


@pytest.mark.parametrize(
    ("held", "phrase"),
    [(0, ""), (1, "1 bound of clean drives; nearest: m0 short"), (2, "2 bounds of clean drives; nearest: m0 short")],
)
def test_bounds_of_clean_drives_that_hold_are_one_phrase(held: int, phrase: str) -> None:
    kept = [verdict("a"), verdict("b", "FAIL", clean=True)]
    clean = [verdict(f"m{k}", clean=True, short=f"m{k} short at t=1.00 s", used=0.9 - 0.1 * k) for k in range(held)]
    assert without_clean([*clean, *kept]) == (kept, phrase)


@pytest.mark.parametrize(
    ("replay", "metrics", "optional", "told", "added"),
    [
        ("dvp run a", ["m", "x y"], ["E"], "dvp run a --gate m --gate 'x y' --optional-event E",
         " --gate m --gate 'x y' --optional-event E"),
        ("dvp run a", [], ["E"], "dvp run a --optional-event E", " --optional-event E"),
        ("dvp run a", [], [], "dvp run a", ""),
        ("pytest x", ["m", "n"], ["E", "F"], "pytest x; judged there: m, n; optional there: E, F", ""),
        ("pytest x", [], [], "pytest x", ""),
    ],
)  # fmt: skip
def test_a_replay_on_conditions(replay: str, metrics: list[str], optional: list[str], told: str, added: str) -> None:
    assert on_condition(replay, metrics, optional) == told
    assert condition_of(told) == added


def test_the_conditions_of_a_run() -> None:
    given = result(ads="mine", compute_delay=0.05, set={"v": 3, "a": 1})
    assert conditions(given) == "a.xosc, stage dt, seed 3, ADS mine, compute delay 0.05, a=1, v=3"


@pytest.mark.parametrize(
    ("more", "page"),
    [
        ({}, None),
        ({"folder": "r"}, "r/report.html"),
        ({"folder": "r", "notes": ["not written: r/report.html: full"]}, None),
        ({"folder": "r", "notes": ["not written: r/log.csv: full"]}, "r/report.html"),
        ({"folder": "r", "notes": ["about report.html: fine"]}, "r/report.html"),
    ],
)
def test_the_page_of_a_run(more: dict[str, Any], page: str | None) -> None:
    assert page_of(result(**more)) == page


# --- names of signals


@pytest.mark.parametrize(
    ("metric", "name", "text"),
    [
        ("max_jerk", "nonsense", None),
        ("mncc", "v", None),
        ("mncc", "ads.anything", None),
        ("mncc", "objects.x", None),
        ("response_lag", "objects.x", "unknown signal 'objects.x'"),
        ("mncc", "object.car.x", None),
        ("mncc", "object.a.b.yaw", None),
        ("mncc", "object.car.z", "unknown signal 'object.car.z'"),
        ("mncc", "object.x", "unknown signal 'object.x'"),
        ("response_lag", "object.car.x", "unknown signal 'object.car.x'"),
        (OF_MODEL[0], "ads.anything", "unknown signal 'ads.anything'"),
        ("twin_error", "position", None),
        ("twin_chi2", "position", "unknown signal 'position'"),
        ("twin_gain", "yaw_rate", None),
        ("twin_gain", "yawrate", "unknown signal 'yawrate'"),
        ("repeated_commands", "gate.steer_cmd", None),
        ("repeated_commands", "steer_command", "unknown signal 'steer_command'"),
        ("steer_roughness", "steer_command", "unknown signal 'steer_command'"),
        ("accel_roughness", "ads.anything", None),
        ("accel_roughness", "acc_cmd", "unknown signal 'acc_cmd'"),
        ("mncc", "q" * 90, f"unknown signal '{'q' * 80}'"),
        ("mncc", 7, "the signal is '7'"),
        ("mncc", ["q" * 90], f"the signal is {str(['q' * 90])[:40]!r}"),
    ],
)
def test_names_of_signals(metric: str, name: object, text: str | None) -> None:
    wrong = wrong_signal(metric, name)
    assert (None if wrong is None else wrong.text) == text


def test_a_misspelt_signal_has_a_hint() -> None:
    wrong = wrong_signal("mncc", "yaw_rat")
    assert wrong is not None
    assert (wrong.allowed, wrong.hint) == ("", nearest("yaw_rat", ["yaw_rate"]))
    wrong = wrong_signal("mncc", "object.car.z")
    assert wrong is not None
    assert wrong.allowed == "object.NAME.x, y, yaw, vx, vy"


def test_unknown_entities_are_told_with_the_number_of_their_gate(tmp_path: Path) -> None:
    from types import SimpleNamespace

    file = tmp_path / "g.toml"
    file.write_text('[[gate]]\nmetric = "mncc"\n[[gate]]\nmetric = "mncc"\nsignal = "object.target.x"\n')
    scenario: Any = SimpleNamespace(
        entities=[SimpleNamespace(name="target"), SimpleNamespace(name="ego")], storyboard=None
    )
    gates = (
        Gate("mncc", options={"signal": "object.target.x"}, file=str(file), line=1),
        Gate("mncc", options={"signal": "object.tarmet.x"}, file=str(file), line=3),
        Gate("mncc", options={"signal": "object.zzz.x"}, file="gone.toml", line=8),
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("pytest_dvp.verdicts.gate_references.EventNames", lambda scenario: ())
        found = list(unknown_names(GateFile(None, gates, "g.toml"), scenario, "s.xosc"))
    assert [(f.severity, f.element, f.line, f.found) for f in found] == [
        ("error", "gate[2].signal", 5, "tarmet"),
        ("warning", "gate[3].signal", 8, "zzz"),
    ]


@pytest.mark.parametrize(
    ("cell", "text"),
    [
        (Cell(None), "-"),
        (Cell(0.0), "0"),
        (Cell(1e-4), "0.0001"),
        (Cell(-9.9e-5), "-9.9e-05"),
        (Cell(123.456), "123.5"),
        (Cell(0.99812, 0.12, 1.0041), "0.9981 +0.12 s x1.004"),
        (Cell(0.5, -0.02, None), "0.5"),
    ],
)
def test_a_cell_of_the_table_of_stages(cell: Cell, text: str) -> None:
    assert cell.text == text


def test_verdicts_of_one_reason_stand_where_the_first_of_them_was() -> None:
    dark = [verdict(name, "INCONCLUSIVE", reason="dark") for name in ("m0", "m1")]
    found = gathered([dark[0], verdict("b", "FAIL"), dark[1], verdict("c")])
    assert [v["short"] for v in found] == ["m0, m1 INCONCLUSIVE: dark", "b short", "c short"]
