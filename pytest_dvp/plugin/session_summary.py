"""What a session says at its end: the terminal section, GitHub annotations, the step summary.

Plain dicts in, lines out.
A result is a dict as `RunResult.as_dict` makes it: scenario, line, stage, status, seed, verdicts (dicts of
gates.Verdict), metrics {name: number or None}, folder, replay. Imports nothing heavy.
"""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from pytest_dvp.drive.run_spec import REFERENCE, nearest
from pytest_dvp.logs.silent_events import is_of_events, missed
from pytest_dvp.plugin.run_summary import NOT_ASKED, is_of_the_run
from reports.verdicts import SEVERITY as ORDER
from reports.verdicts import urgency

Result = Mapping[str, Any]

MAX_LINES = 20
MAX_NOTES = 5
FEW = 3  # gates that are named where they share a reason
MAX_TABLES = 3
NOT_WRITTEN = "not written: "  # begins the note on a file that could not be written
BESIDE_VERDICTS = ("not judged:", "recording:", "command gate:", NOT_WRITTEN)
"""Begins of notes without which verdicts mislead, or a user looks for files in vain."""
DIFFERENT = " differ in "  # of a note that two drives were not the same test
GOOD = ("PASS", NOT_ASKED)
WHY = "what the twin lacks"  # before the command that says it
GATE, OPTIONAL = "--gate", "--optional-event"  # of `dvp run`: as `metrics` and `optional_events` of the fixture `gate`


def clean(text: object) -> str:
    """Text from a file without control characters, so that it cannot steer a terminal."""
    return "".join(c if c.isprintable() else "?" for c in str(text))


def reason(verdict: Mapping[str, Any]) -> str:
    """One phrase: `max_ttc_inverse 1.31 1/s > 1.00 at t=7.42 s (target)`."""
    return clean(verdict["short"])


def worst_first(verdicts: Iterable[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """Verdicts in the order of `reports.verdicts.urgency`."""
    return sorted(verdicts, key=urgency)


def worst_status(verdicts: Iterable[Mapping[str, Any]]) -> str:
    """The worst status of verdicts, as texts."""
    return min((verdict["status"] for verdict in verdicts), key=lambda status: ORDER.get(status, 0), default=NOT_ASKED)


def gathered(verdicts: Iterable[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """The verdicts in their order; those that are INCONCLUSIVE for one reason are one, which names or counts them."""
    given = list(verdicts)
    alike: dict[str, list[Mapping[str, Any]]] = {}
    for verdict in given:
        if verdict["status"] == "INCONCLUSIVE" and verdict.get("reason"):
            alike.setdefault(verdict["reason"], []).append(verdict)
    out: list[Mapping[str, Any]] = []
    for verdict in given:
        group = alike.get(verdict.get("reason", ""), []) if verdict["status"] == "INCONCLUSIVE" else []
        if len(group) < 2:
            out.append(verdict)
        elif verdict is group[0]:
            names = ", ".join(v.get("name") or v["metric"] for v in group[:FEW])
            called = names if len(group) <= FEW else f"{len(group)} gates ({names}, ...)"
            short = f"{called} INCONCLUSIVE: {verdict['reason']}"
            first = min((v for v in group), key=lambda v: (v["file"], v["line"] or 0))
            place = f"{first['file']}:{first['line']}" if first["line"] else first["file"]
            message = f"{short}; the first is gate {place}" if place else short
            out.append({**verdict, "short": short, "message": message})
    return out


def asked_verdicts(result: Result, metrics: Sequence[str] | None = None) -> list[Mapping[str, Any]]:
    """The verdicts that decide: all, or those on these metrics with what no choice leaves out.

    That is a run that broke, and events that never fired.
    """
    verdicts = [
        v
        for v in result["verdicts"]
        if metrics is None or v["metric"] in metrics or v["gate"] in metrics or is_of_the_run(v) or is_of_events(v)
    ]
    silent = missed(result) if all(v["status"] == "PASS" for v in verdicts) else None
    return verdicts if silent is None else [*verdicts, silent]


def undecided(result: Result, metrics: Sequence[str] | None = None) -> bool:
    """Whether the verdicts asked for are not PASS only because something was not measured or did not happen."""
    statuses = {verdict["status"] for verdict in asked_verdicts(result, metrics)}
    return not _missing(result, metrics) and statuses - {"PASS"} == {"INCONCLUSIVE"}


def failure(result: Result, metrics: Sequence[str] | None = None) -> str | None:
    """Message of a run that is not PASS, or None. First line the reason, last line the command to replay."""
    verdicts, missing = asked_verdicts(result, metrics), _missing(result, metrics)
    bad = sorted((v for v in verdicts if v["status"] != "PASS"), key=urgency)
    measured = result.get("metrics", {})
    judged = verdicts if metrics is None else [v for v in verdicts if not is_of_events(v) or v["metric"] in metrics]
    status = result["status"] if metrics is None else ("PASS" if judged and not missing else "INCONCLUSIVE")
    if not bad and status == "PASS":
        return None
    lines = [reason(bad[0]) if bad else _no_verdict(status, missing, result["verdicts"], measured)]
    lines += [f"  {clean(line)}" for line in str(result.get("error") or "").splitlines()]
    for verdict in gathered(bad):
        lines.append(f"  {verdict['status']} {clean(verdict['message'])}")
    lines += [f"  {clean(line)}" for line in result.get("explanation", ())]
    passed = sum(v["status"] == "PASS" for v in verdicts)
    lines += [
        f"  {clean(note)}" for note in result.get("notes", ()) if note.startswith(BESIDE_VERDICTS) or DIFFERENT in note
    ]
    lines.append(f"  {passed} of {len(verdicts)} gates passed; {conditions(result)}")
    if result.get("ended"):
        lines.append(f"  ended by {clean(result['ended'])} at t={result['simulated']:.2f} s")
    if page := page_of(result):
        lines.append(f"  report: {clean(page)}")
    lines += [f"  {WHY}: {clean(command)}" for command in result.get("why", ())]
    lines.append(f"  replay: {clean(result['replay'])}")
    return "\n".join(lines)


def on_condition(replay: str, metrics: Sequence[str], optional: Sequence[str] = ()) -> str:
    """A replay command that judges these gates only and lets these events be; where there is no command, a phrase."""
    if not replay.startswith("dvp run "):
        told = [f"judged there: {', '.join(metrics)}"] if metrics else []
        told += [f"optional there: {', '.join(optional)}"] if optional else []
        return "; ".join([replay, *told])
    words = [f"{GATE} {shlex.quote(name)}" for name in metrics]
    return " ".join([replay, *words, *(f"{OPTIONAL} {shlex.quote(name)}" for name in optional)])


def condition_of(replay: str) -> str:
    """What `on_condition` has added to a command, with a space before it; empty if nothing."""
    starts = [replay.find(f" {option} ") for option in (GATE, OPTIONAL)]
    found = [start for start in starts if start >= 0]
    return replay[min(found) :] if found and replay.startswith("dvp run ") else ""


def conditions(result: Result) -> str:
    """Scenario, stage, seed and the parameters that were set."""
    words = [f"{result['scenario']}", f"stage {result['stage']}", f"seed {result['seed']}"]
    words += [f"ADS {result['ads']}"] if result.get("ads", REFERENCE) != REFERENCE else []
    words += [f"compute delay {result['compute_delay']}"] if result.get("compute_delay") else []
    words += [f"{name}={value}" for name, value in sorted(result.get("set", {}).items())]
    return clean(", ".join(words))


def cases(reports: Iterable[Any]) -> list[dict[str, Any]]:
    """Results of a session's reports, worst first."""
    found = [dict(result, nodeid=report.nodeid) for report in reports for result in report.dvp]
    return sorted(found, key=lambda case: (*min(map(urgency, case["verdicts"]), default=(0, 0, 0.0)), case["nodeid"]))


def lines(results: Sequence[Result], limit: int = MAX_LINES) -> list[str]:
    """The terminal section: one line a gate, worst margin first, at most `limit`, the last one an action."""
    judged = [verdict["status"] for case in results for verdict in case["verdicts"]]
    rows = sorted(
        ((urgency(verdict), case, verdict) for case in results for verdict in gathered(case["verdicts"])),
        key=lambda row: (*row[0], row[1]["nodeid"], row[2]["gate"]),
    )
    tally = ", ".join(f"{judged.count(status)} {status}" for status in ORDER if status in judged) or "nothing judged"
    runs = sum(case.get("driven", 1) for case in results)
    out = [f"{_count(runs, 'run')}, {_count(len(judged), 'gate')}: {tally}"]
    said = [*vacuous(results), *notes(results)]
    room = limit - 2 - len(said)
    shown = rows if len(rows) <= room else rows[: room - 1]
    for _, case, verdict in shown:
        # Where a passed gate came nearest to its bound is in the report; here it would only break the line.
        why = reason(verdict).split(" at t=")[0] if verdict["status"] == "PASS" else reason(verdict)
        chosen = f" (tightest of {case['driven']} runs)" if case.get("tightest") else ""
        out.append(clean(f"{verdict['status']:<12} {_name(case)}{chosen} {why}{_margin(verdict)}"))
    if len(shown) < len(rows):
        left_out = " or not asked for" if rows[-1][2]["status"] == NOT_ASKED else ""
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


def table_lines(table: Mapping[str, Any]) -> list[str]:
    """A table of stages (StageTable.as_dict) for a terminal."""
    texts = [(_row_name(row), [cell["text"] for cell in row["cells"]]) for row in table["rows"]]
    heads = [f"{a} to {b}" if b else a for a, b in zip(table["stages"], table["against"], strict=True)]
    wide = [max(len(head), *(len(cells[k]) for _, cells in texts)) for k, head in enumerate(heads)]
    left = max(len(name) for name, _ in texts)
    out = [" " * left + "".join(f"  {head:>{w}}" for head, w in zip(heads, wide, strict=True))]
    for name, cells in texts:
        out.append(f"{name:<{left}}" + "".join(f"  {cell:>{w}}" for cell, w in zip(cells, wide, strict=True)))
    return out


def _row_name(row: Mapping[str, Any]) -> str:
    if row["metric"] == "mncc":
        return f"MNCC {row['name']}"
    return row["name"] if row["unit"] == "-" else f"{row['name']} [{row['unit']}]"


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


def notes(results: Sequence[Result], limit: int = MAX_NOTES) -> list[str]:
    """What is bad and not judged, and what of the storyboards is doubtful; at most `limit` lines."""
    found = [(case, note) for case in results for note in case.get("notes", ())]
    found.sort(key=lambda pair: (not pair[1].startswith(NOT_WRITTEN), not pair[1].startswith("not judged:")))
    said = list(dict.fromkeys(clean(f"{_name(case)}: {note}") for case, note in found))
    return said if len(said) <= limit else [*said[: limit - 1], f"... {len(said) - limit + 1} more notes"]


def action(results: Sequence[Result]) -> str:
    """What to do next: replay the worst run, or look at its report."""
    worst = results[0]
    if worst["status"] not in GOOD:
        return clean(f"replay the worst: {worst['replay']}")
    page = page_of(worst)
    return clean(f"see the tightest run: {page}" if page else f"see it again: {worst['replay']}")


def page_of(result: Result) -> str | None:
    """The report of a run; None if there is none, or it could not be written."""
    folder = result.get("folder")
    lost = any(note.startswith(NOT_WRITTEN) and "report.html:" in note for note in result.get("notes", ()))
    return None if not folder or lost else f"{folder}/report.html"


def github_annotations(results: Sequence[Result]) -> list[str]:
    """GitHub workflow commands that mark the line of the .xosc a failing run is about."""
    return [
        f"::error file={_property(case['scenario'])},line={case.get('line') or 1}"
        f",title={_property(Path(case['scenario']).name + '::' + case['stage'])}::{_data(_reasons(case))}"
        for case in results
        if case["status"] not in GOOD
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
        for v in sorted(case["verdicts"], key=urgency):
            cells = [case["scenario"], case["stage"], v["gate"], v["status"], _with_unit(v, "value")]
            cells += [_with_unit(v, "bound"), _number(v["margin"]) if _finite(v.get("margin")) else ""]
            rows.append("| " + " | ".join(_cell(cell) for cell in cells) + " |")
    said = vacuous(results, len(results))
    rows += ["", *(f"- {_cell(line)}" for line in said)] if said else []
    with path.open("a", encoding="utf-8") as stream:
        stream.write("\n".join([*rows, "", ""]))


def _count(n: int, noun: str) -> str:
    return f"{n} {noun}" if n == 1 else f"{n} {noun}s"


def _name(case: Result) -> str:
    """`overtaking.xosc::dt`; a run of a test of one's own carries the test's name."""
    item = str(case["nodeid"]).rsplit("/", 1)[-1]
    return item if ".xosc::" in item else f"{item} {Path(case['scenario']).stem}"


def _reasons(case: Result) -> str:
    bad = sorted((v for v in case["verdicts"] if v["status"] not in GOOD), key=urgency)
    return "\n".join([*(reason(v) for v in bad), f"replay: {case['replay']}"]) if bad else str(case["status"])


def _missing(result: Result, metrics: Sequence[str] | None) -> list[str]:
    return [name for name in metrics or () if not any(name in (v["metric"], v["gate"]) for v in result["verdicts"])]


def _no_verdict(
    status: str, missing: Sequence[str], verdicts: Sequence[Mapping[str, Any]], measured: Mapping[str, Any]
) -> str:
    if missing:
        names = {name for v in verdicts for name in (v["metric"], v["gate"]) if name} | set(measured)
        near = {name: nearest(name, names) for name in missing if name not in names}
        hints = [f"did you mean {right!r} for {name!r}?" for name, right in near.items() if right]
        return "; ".join([f"{status}: no gate on {', '.join(missing)}", *hints])
    return f"{status}: no gate was judged, and nothing judged is never a PASS"


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
