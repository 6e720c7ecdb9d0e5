"""What a session says at its end: the terminal section, GitHub annotations, the step summary.

Plain dicts in, lines out.
A result is a dict as `RunResult.as_dict` makes it: scenario, line, stage, status, seed, verdicts (dicts of
gates.Verdict), metrics {name: number or None}, folder, replay. Imports nothing heavy.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from pytest_dvp.text.names import NOT_ASKED
from pytest_dvp.text.printable import clean
from pytest_dvp.verdicts.result_text import NOT_WRITTEN, Result, conditions, gathered, page_of, reason, without_clean
from pytest_dvp.verdicts.stage_table_text import table_lines
from reports.verdicts import HARM, urgency
from reports.verdicts import SEVERITY as ORDER

MAX_LINES = 20  # runs in the summary; chosen: a screen
MAX_NOTES = 5  # of one kind; chosen, not measured
MAX_TABLES = 3  # of stages; chosen, not measured
GOOD = ("PASS", NOT_ASKED)


def cases(reports: Iterable[Any]) -> list[dict[str, Any]]:
    """Results of a session's reports, worst first.

    Several reports may tell of one test's runs of a scenario and stage, as those of its subtests and its teardown do:
    the worst of them stands for all.
    """
    found: dict[tuple[str, ...], dict[str, Any]] = {}
    for report in reports:
        for result in report.dvp:
            key = (report.nodeid, result["scenario"], result["stage"])
            other = found.get(key, {})
            worse = min((one for one in (other, result) if one), key=_worst)
            driven = max(other.get("driven", 1), result.get("driven", 1))
            found[key] = dict(worse, nodeid=report.nodeid, driven=driven)
    return sorted(found.values(), key=lambda case: (*_worst(case), case["nodeid"]))


def _worst(case: Mapping[str, Any]) -> tuple[float, int, float]:
    """The urgency of a run's worst gate."""
    return min(map(urgency, case["verdicts"]), default=(0, 0, 0.0))


def lines(results: Sequence[Result], limit: int = MAX_LINES) -> list[str]:
    """The terminal section: one line a gate, worst margin first, at most `limit`, the last one an action."""
    every = [verdict for case in results for verdict in case["verdicts"]]
    judged = [verdict["status"] for verdict in every]
    clean_bounds = sum(bool(verdict.get("clean")) for verdict in every)
    rows = sorted(
        (
            (_place(verdict), case, verdict)
            for case in results
            for verdict in gathered(without_clean(case["verdicts"])[0])
        ),
        key=lambda row: (*row[0], row[1]["nodeid"], row[2]["gate"]),
    )
    tally = ", ".join(f"{judged.count(status)} {status}" for status in ORDER if status in judged) or "nothing judged"
    runs = sum(case.get("driven", 1) for case in results)
    counted = [_count(runs, "run"), _count(len(judged) - clean_bounds, "gate")]
    if clean_bounds:
        counted.append(f"{_count(clean_bounds, 'bound')} of clean drives")
    out = [f"{', '.join(counted)}: {tally}"]
    said = [*never_judged(results), *vacuous(results), *notes(results)]
    room = limit - 2 - len(said)
    shown = rows if len(rows) <= room else rows[: room - 1]
    for _, case, verdict in shown:
        # Where a passed gate came nearest to its bound is in the report; here it would only break the line.
        why = reason(verdict).split(" at t=")[0] if verdict["status"] == "PASS" else reason(verdict)
        chosen = f" (tightest of {case['driven']} runs)" if case.get("tightest") else ""
        out.append(clean(f"{verdict['status']:<12} {_name(case)}{chosen} {why}{_margin(verdict)}"))
    if len(shown) < len(rows):
        left_out = " or not asked for" if any(row[2]["status"] == NOT_ASKED for row in rows[len(shown) :]) else ""
        out.append(f"... {len(rows) - len(shown)} more gates with larger margins{left_out}")
    out += said
    out.append(action(results))
    return out


def stage_tables(results: Sequence[Result], limit: int = MAX_TABLES) -> list[str]:
    """The table of stages of each scenario that was compared, the widest one; of at most `limit` scenarios."""
    widest: dict[str, Result] = {}
    for case in results:
        if case.get("table") and len(case["table"]["stages"]) > len(
            widest.get(case["scenario"], {"table": {"stages": ()}})["table"]["stages"]
        ):
            widest[case["scenario"]] = case
    out: list[str] = []
    for name in sorted(widest)[:limit]:
        case = widest[name]
        out += ["", clean(f"{conditions({**case, 'stage': ', '.join(case['table']['stages'])})}")]
        out += [clean(line) for line in table_lines(case["table"])]
        if page := page_of(case):
            out.append(clean(f"page: {page}"))
    if len(widest) > limit:
        out.append(f"... {len(widest) - limit} more tables in the run folders")
    return out[1:]


def vacuous(results: Sequence[Result], limit: int = MAX_NOTES) -> list[str]:
    """How many variants of each search did not let an event fire, at most `limit` lines: `12 of 100 variants: ...`."""
    said = []
    for case in results:
        search = case.get("search") or {"variants": 0, "never_fired": {}}
        counts = [
            f"{count} of {search['variants']} variants: event {name!r} never fired"
            for name, count in search["never_fired"].items()
        ]
        said += [clean(f"{_name(case)}: {'; '.join(counts)}")] if counts else []
    return said if len(said) <= limit else [*said[: limit - 1], f"... {len(said) - limit + 1} more searches"]


def never_judged(results: Sequence[Result], limit: int = MAX_NOTES) -> list[str]:
    """Runs of passed tests that were given to no `gate`, and would not have passed; at most `limit` lines."""
    said = [
        clean(f"{_name(case)}: never judged: {_count(case['never_judged'], 'gate')} did not pass, and the test never "
              "calls gate(result)")
        for case in results if case.get("never_judged")
    ]  # fmt: skip
    return said if len(said) <= limit else [*said[: limit - 1], f"... {len(said) - limit + 1} more never judged"]


def notes(results: Sequence[Result], limit: int = MAX_NOTES) -> list[str]:
    """What is bad and not judged, and what of the storyboards is doubtful; at most `limit` lines."""
    found = [(case, note) for case in results for note in case.get("notes", ())]
    found.sort(key=lambda pair: (not pair[1].startswith(NOT_WRITTEN), not pair[1].startswith("not judged:")))
    said = list(dict.fromkeys(clean(f"{_name(case)}: {note}") for case, note in found))
    return said if len(said) <= limit else [*said[: limit - 1], f"... {len(said) - limit + 1} more notes"]


def action(results: Sequence[Result]) -> str:
    """What to do next: replay the worst run that no `xfail` expects, or look at the report of the tightest one."""
    worst = next((case for case in results if not case.get("expected")), results[0])
    if worst["status"] not in GOOD:
        return clean(f"replay the worst: {worst['replay']}")
    page = page_of(worst)
    return clean(f"see the tightest run: {page}" if page else f"see it again: {worst['replay']}")


def github_annotations(results: Sequence[Result]) -> list[str]:
    """GitHub workflow commands that mark the line of the .xosc a failing run is about; none for an `xfail`."""
    return [
        f"::error file={_property(case['scenario'])},line={case.get('line') or 1}"
        f",title={_property(Path(case['scenario']).name + '::' + case['stage'])}::{_data(_reasons(case))}"
        for case in results
        if case["status"] not in GOOD and not case.get("expected")
    ]


def append_table(path: Path, results: Sequence[Result]) -> None:
    """Append a Markdown table of all gates to GitHub's step summary file."""
    rows = [
        "### dvp",
        "",
        "| scenario | stage | gate | verdict | value | bound | margin |",
        "|---|---|---|---|---|---|---|",
    ]
    for case in results:
        for v in sorted(case["verdicts"], key=_place):
            cells = [case["scenario"], case["stage"], v["gate"], v["status"], _with_unit(v, "value")]
            cells += [_with_unit(v, "bound"), _number(v["margin"]) if _finite(v.get("margin")) else ""]
            rows.append("| " + " | ".join(_cell(cell) for cell in cells) + " |")
    said = [*never_judged(results, len(results)), *vacuous(results, len(results))]
    rows += ["", *(f"- {_cell(line)}" for line in said)] if said else []
    with path.open("a", encoding="utf-8") as stream:
        stream.write("\n".join([*rows, "", ""]))


def _place(verdict: Mapping[str, Any]) -> tuple[float, int, float]:
    """Sort key: as `urgency`, but what did not pass and was not asked for stands before what passed, and harm of it
    with that of the failures."""
    order, harm, left = urgency(verdict)
    if verdict["status"] != NOT_ASKED:
        return order, harm, left
    return (ORDER["FAIL"] if verdict["metric"] in HARM else ORDER["PASS"] - 0.5), harm, left


def _count(n: int, noun: str) -> str:
    return f"{n} {noun}" if n == 1 else f"{n} {noun}s"


def _name(case: Result) -> str:
    """`overtaking.xosc::dt`; a run of a test of one's own carries the test's name."""
    file, colons, item = str(case["nodeid"]).partition("::")  # a "/" in the brackets of a parameter is no folder
    short = f"{file.rsplit('/', 1)[-1]}{colons}{item}"
    expected = " (expected)" if case.get("expected") else ""
    if file.lower().endswith(".xosc"):
        return short + expected
    return f"{short} {case.get('called') or Path(case['scenario']).stem}{expected}"


def _reasons(case: Result) -> str:
    bad = sorted((v for v in case["verdicts"] if v["status"] not in GOOD), key=urgency)
    return "\n".join([*(reason(v) for v in bad), f"replay: {case['replay']}"]) if bad else str(case["status"])


def _margin(verdict: Mapping[str, Any]) -> str:
    margin = verdict.get("margin")
    return f", margin {_number(margin)}" if _finite(margin) and margin is not None else ""


def _with_unit(verdict: Mapping[str, Any], key: str) -> str:
    value, unit = verdict.get(key), verdict.get("unit") or ""
    return f"{_number(value)} {unit if unit != '-' else ''}".strip() if _finite(value) and value is not None else ""


def _finite(value: object) -> bool:
    return isinstance(value, int | float) and math.isfinite(value)


def _number(value: float) -> str:
    return f"{value:.3g}" if abs(value) < 100 else f"{value:.1f}"


def _cell(text: object) -> str:
    escaped = clean(text).replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return escaped.replace("|", "\\|").replace("`", "\\`")


def _data(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _data(clean(text)).replace(":", "%3A").replace(",", "%2C")
