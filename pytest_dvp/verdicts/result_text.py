"""What a run says of itself: why it is no PASS, on which conditions, and how to replay it."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from pytest_dvp.text.names import REFERENCE
from pytest_dvp.text.printable import clean
from pytest_dvp.text.spelling import nearest
from pytest_dvp.verdicts.broken_run import is_of_the_run
from pytest_dvp.verdicts.silent_events import is_of_events, missed
from reports.verdicts import urgency

Result = Mapping[str, Any]


FEW = 3  # gates that are named where they share a reason


NOT_WRITTEN = "not written: "  # begins the note on a file that could not be written


BESIDE_VERDICTS = ("not judged:", "recording:", "guard:", NOT_WRITTEN)
"""Begins of notes without which verdicts mislead, or a user looks for files in vain."""


DIFFERENT = " differ in "  # of a note that two drives were not the same test


WHY = "what the twin lacks"  # before the command that says it


GATE, OPTIONAL = "--gate", "--optional-event"  # of `dvp run`: as `metrics` and `optional_events` of the fixture `gate`


def reason(verdict: Mapping[str, Any]) -> str:
    """One phrase: `max_ttc_inverse 1.31 1/s > 1.00 at t=7.42 s (target)`."""
    return clean(verdict["short"])


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


def without_clean(verdicts: Iterable[Mapping[str, Any]]) -> tuple[list[Mapping[str, Any]], str]:
    """The verdicts without bounds of clean drives that hold, and one phrase for those, "" for none.

    There are dozens of them, and as long as they hold they say nothing that a reader must know.
    """
    shown: list[Mapping[str, Any]] = []
    held: list[Mapping[str, Any]] = []
    for verdict in verdicts:
        (held if verdict.get("clean") and verdict["status"] == "PASS" else shown).append(verdict)
    if not held:
        return shown, ""
    near = reason(min(held, key=urgency)).split(" at t=")[0]
    return shown, f"{len(held)} bound{'' if len(held) == 1 else 's'} of clean drives; nearest: {near}"


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
    told = gathered(bad)
    broken = [verdict for verdict in told if verdict.get("clean")]
    for verdict in told[: len(told) - max(len(broken) - FEW, 0)]:  # bounds of clean drives come last
        lines.append(f"  {verdict['status']} {clean(verdict['message'])}")
    if len(broken) > FEW:
        lines.append(f"  ... and {len(broken) - FEW} more bounds that clean drives keep")
    lines += [f"  {clean(line)}" for line in result.get("explanation", ())]
    passed = [v for v in verdicts if v["status"] == "PASS"]
    of_clean = [v for v in verdicts if v.get("clean")]
    kept = f", {sum(v in passed for v in of_clean)} of {len(of_clean)} bounds of clean drives" if of_clean else ""
    gates = len(verdicts) - len(of_clean)
    lines += [
        f"  {clean(note)}" for note in result.get("notes", ()) if note.startswith(BESIDE_VERDICTS) or DIFFERENT in note
    ]
    lines.append(f"  {sum(not v.get('clean') for v in passed)} of {gates} gates passed{kept}; {conditions(result)}")
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


def page_of(result: Result) -> str | None:
    """The report of a run; None if there is none, or it could not be written."""
    folder = result.get("folder")
    lost = any(note.startswith(NOT_WRITTEN) and "report.html:" in note for note in result.get("notes", ()))
    return None if not folder or lost else f"{folder}/report.html"


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
