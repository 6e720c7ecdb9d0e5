"""Gates: bounds on metrics of a log -> verdicts with margins. Nothing measured is never a PASS."""

from __future__ import annotations

import collections
import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from pytest_dvp.logs.event_reference import means_event
from pytest_dvp.logs.log import Log
from pytest_dvp.metrics import MetricValue, compute, find_metric
from pytest_dvp.metrics.registry import why_failed
from pytest_dvp.metrics.task_outcome import storyboard_events
from pytest_dvp.verdicts.clean_gates import applies
from pytest_dvp.verdicts.excited_parameters import unexcited
from pytest_dvp.verdicts.gate import STAGES, Gate, GateError, GateFile, GateTask, GateTraffic, Stage
from pytest_dvp.verdicts.gate_file import check_gates, read_gates
from pytest_dvp.verdicts.no_evidence import ended_early, no_evidence
from pytest_dvp.verdicts.silent_events import COUNTED, storyboard_verdict

__all__ = [
    "STAGES",
    "Gate",
    "GateError",
    "GateFile",
    "GateTask",
    "GateTraffic",
    "Stage",
    "Verdict",
    "check_gates",
    "default_gates",
    "judge",
    "judge_between",
    "never_fired",
    "overall",
    "pairs_of",
    "read_gates",
    "unjudged",
]

Status = Literal["PASS", "FAIL", "INCONCLUSIVE", "ERROR"]
_WORST_FIRST: tuple[Status, ...] = ("ERROR", "FAIL", "INCONCLUSIVE", "PASS")


@dataclasses.dataclass(frozen=True, slots=True)
class Verdict:
    """Judgement of one gate.

    gate     what was asked, as "max_ttc_inverse <= 1.00 1/s"
    name     what is bounded, as its gate file calls it: the metric, of a model "rmse(v, car.toml)"
    value    the metric, None if it is not defined; bound: the limit it came nearest to or broke, both in `unit`
    margin   distance to that limit in `unit`, negative if broken
    used     share of what that limit allows, 1 at it, > 1 if broken; None where a share has no meaning (a bound of 0)
    t, object  time [s] and road user of the worst moment
    short    one line for a summary; message: the same with margin and the place of the gate, file:line
    reason   why there is no value, the same text for all gates that share it
    requirement  id of the requirement that the gate verifies, if its file names one
    clean    True for a bound that clean drives keep, the table [clean] of a gate file: no requirement
    """

    gate: str
    metric: str
    status: Status
    value: float | None
    unit: str
    bound: float | None
    margin: float | None
    t: float | None
    object: str
    message: str
    short: str
    file: str
    line: int | None
    name: str = ""
    used: float | None = None
    reason: str = ""
    requirement: str = ""
    clean: bool = False

    def as_dict(self) -> dict[str, Any]:
        """Plain JSON-able data."""
        return dataclasses.asdict(self)


def default_gates() -> GateFile:
    """The gates of a scenario that brings none: no collision, no road departure, scenario ended."""
    gates = (Gate("collision", max=0.0), Gate("road_departure", max=0.0), Gate("scenario_ended", min=1.0))
    return GateFile(None, gates)


def judge(gates: GateFile | Sequence[Gate], log: Log) -> list[Verdict]:
    """Verdicts of the gates that apply to the log's stage (meta `stage`), in the order of the file; those across stages
    need two logs: `judge_between`.

    No gate at all, or none for this stage, is one INCONCLUSIVE verdict; a file whose gates are all across stages leaves
    the stage itself to the default gates. INCONCLUSIVE is a storyboard with an event that never fired where all gates
    pass: what should have happened did not, and a drive in an empty world proves nothing. A gate on `events_fired`
    decides instead of this, one on `event_started` for its event.
    """
    here = _here(gates, log)
    verdicts = _told_apart(here, [_judge(gate, log) for gate in here])
    if verdicts:
        missed = never_fired(gates, log) if overall(verdicts) == "PASS" else ()
        return [*verdicts, *_storyboard(missed, log)]
    file = gates.file if isinstance(gates, GateFile) else ""
    text = f"no gate applies to stage {log.meta.get('stage', 'dt')}: nothing was judged"
    return [Verdict("", "", "INCONCLUSIVE", None, "", None, None, None, "", text, text, file, None)]


def _told_apart(gates: Sequence[Gate], verdicts: Sequence[Verdict]) -> list[Verdict]:
    """Verdicts whose labels are those of others get the options of their gates, or one would stand for both."""
    count = collections.Counter(verdict.gate for verdict in verdicts)
    return [
        dataclasses.replace(verdict, gate=verdict.gate.replace(gate.metric, f"{gate.metric}({_options(gate)})", 1))
        if count[verdict.gate] > 1 and gate.options and gate.only_with is None
        else verdict
        for gate, verdict in zip(gates, verdicts, strict=True)
    ]


def _options(gate: Gate) -> str:
    values = ((key, f"{value:g}" if isinstance(value, float) else value) for key, value in gate.options.items())
    return _printable(", ".join(f"{key}={value}" for key, value in values))


def pairs_of(gates: Iterable[Gate]) -> list[tuple[Stage, Stage]]:
    """The pairs of stages (model, measured) that gates are between, each once, in the order of the gates."""
    return list(dict.fromkeys(gate.between for gate in gates if gate.between is not None))


def judge_between(
    gates: Iterable[Gate],
    pair: tuple[Stage, Stage],
    logs: Mapping[str, Log],
    missing: Mapping[str, str] | None = None,
) -> list[Verdict]:
    """Verdicts of the gates between two stages, from the logs by stage ("dt", "rw").

    Without one of the logs each of them is INCONCLUSIVE; `missing` says by stage why it is not there and how to get it.
    So is each of them if a drive is no evidence: a car that did not know where it was for too long, a twin that was
    scaled to another car than that of its file; and what would pass if one drive ended before half of the other.
    No such gate is one INCONCLUSIVE verdict. A gate that passes and lists `parameters` is INCONCLUSIVE if the drives
    did not excite them all.
    """
    here = [gate for gate in gates if gate.between == pair]
    if not here:
        text = f"no gate is between {pair[0]} and {pair[1]}: nothing was judged"
        return [Verdict("", "", "INCONCLUSIVE", None, "", None, None, None, "", text, text, "", None)]
    for stage in pair:
        if stage not in logs:
            why = (missing or {}).get(stage) or f"no log of stage {stage} to compare with"
            return [_verdict(gate, "INCONCLUSIVE", None, why) for gate in here]
    for stage in pair:
        why = no_evidence(logs[stage])
        if why:
            return [_verdict(gate, "INCONCLUSIVE", None, f"stage {stage}: {why}") for gate in here]
    early = ended_early({stage: logs[stage] for stage in pair})
    return [_with_evidence(gate, _judge(gate, logs[pair[0]], logs[pair[1]]), logs, early) for gate in here]


def _with_evidence(gate: Gate, verdict: Verdict, logs: Mapping[str, Log], early: str) -> Verdict:
    """INCONCLUSIVE in place of PASS if a drive did not excite what the gate is to validate, or ended too early (`early`
    says so) for what is not open loop; a FAIL stays one."""
    if verdict.status != "PASS":
        return verdict
    why = "" if find_metric(gate.metric).open_loop or not early else f"within its bound, but {early}"
    why = why or unexcited(gate, logs)
    if not why:
        return verdict
    short = f"{verdict.name} INCONCLUSIVE: {why}"
    return dataclasses.replace(
        verdict, status="INCONCLUSIVE", short=short, message=f"{short}; {verdict.message}", reason=why
    )


def overall(verdicts: Sequence[Verdict]) -> Status:
    """The worst status: ERROR, FAIL, INCONCLUSIVE, PASS. No verdict at all is INCONCLUSIVE."""
    statuses = {verdict.status for verdict in verdicts}
    return next((status for status in _WORST_FIRST if status in statuses), "INCONCLUSIVE")


def unjudged(verdicts: Sequence[Verdict], log: Log) -> list[str]:
    """What is bad by the default gates and was not judged: `not judged: road_departure 54.65 s (no gate on it)`."""
    judged = {verdict.metric for verdict in verdicts}
    default = [gate for gate in default_gates().gates if gate.metric not in judged]
    missed = [v for v in judge(default, log) if v.value is not None and v.status != "PASS"] if default else []
    return [
        f"not judged: {v.metric} {_pair(v.value, v.value, v.unit)[0]}{_suffix(v.unit)} (no gate on it)"
        for v in missed
        if v.value is not None
    ]


def never_fired(gates: GateFile | Sequence[Gate], log: Log) -> tuple[str, ...]:
    """Names of the storyboard's events that never fired, without those that a gate for the log's stage lets be.

    A gate on `events_fired` that passes lets all of them be, one that does not those of its `optional`; a gate on
    `event_started` that passes lets its event be, which was not to start.
    """
    here, (_, silent) = _here(gates, log), storyboard_events(log)
    let_be: list[str] = []
    for gate in here if silent else ():
        if gate.metric == COUNTED:
            if _judge(gate, log).status == "PASS":
                return ()
            let_be += map(str, gate.options.get("optional", ()))
        elif gate.metric == "event_started" and _judge(gate, log).status == "PASS":
            let_be.append(str(gate.options.get("event", "")))
    return tuple(name for name in silent if not any(means_event(reference, name) for reference in let_be))


def _here(gates: GateFile | Sequence[Gate], log: Log) -> list[Gate]:
    """The gates of one log that apply to it; the default ones where all others are across stages or clean bounds."""
    given = gates.gates if isinstance(gates, GateFile) else tuple(gates)
    stage = str(log.meta.get("stage", "dt")).split("-")[0]  # "rw-surrogate" is judged by the gates of "rw"
    alone = [gate for gate in given if gate.between is None]
    here = [gate for gate in alone if stage in gate.stages and applies(gate, log)]
    if given and all(gate.only_with is not None for gate in alone):
        return [*here, *default_gates().gates]
    return here if any(gate.only_with is None for gate in here) else []  # clean bounds only add to the gates of a stage


def _storyboard(missed: Sequence[str], log: Log) -> list[Verdict]:
    """The verdict that keeps a scenario whose manoeuvre did not take place from passing."""
    return [Verdict(**storyboard_verdict(missed, len(storyboard_events(log)[0])))] if missed else []


def _judge(gate: Gate, log: Log, measured: Log | None = None) -> Verdict:
    try:
        value = _evaluate(gate, log, measured)
    except Exception as error:  # a metric of another package may raise anything; one bad metric must not end the run
        return _verdict(gate, "ERROR", None, why_failed(error))
    if not value.valid or value.value is None:
        return _verdict(gate, "INCONCLUSIVE", value, value.reason)
    missed: Status = find_metric(gate.metric).miss
    return _verdict(gate, "PASS" if _margin(gate, value.value)[0] >= 0.0 else missed, value, "")


def _evaluate(gate: Gate, log: Log, measured: Log | None) -> MetricValue:
    if gate.max_difference is None:
        return compute(gate.metric, log, measured, **gate.options)
    assert gate.between is not None
    assert measured is not None
    both = [compute(gate.metric, each, **gate.options) for each in (log, measured)]
    for stage, one in zip(gate.between, both, strict=True):
        if not one.valid or one.value is None:
            return dataclasses.replace(one, valid=False, value=None, reason=f"stage {stage}: {one.reason}")
    first, second = both[0].value or 0.0, both[1].value or 0.0
    told = _pair(first, second, both[0].unit)
    what = f"{gate.between[0]} {told[0]}, {gate.between[1]} {told[1]}"
    return dataclasses.replace(both[1], value=abs(second - first), t=None, object=what, series=None)


def _margin(gate: Gate, value: float) -> tuple[float, float, str]:
    """Least distance to a bound, that bound, and the relation that holds."""
    limits = []
    if gate.max_difference is not None:
        limits.append((gate.max_difference - value, gate.max_difference, "<=" if value <= gate.max_difference else ">"))
    if gate.max is not None:
        limits.append((gate.max - value, gate.max, "<=" if value <= gate.max else ">"))
    if gate.min is not None:
        limits.append((value - gate.min, gate.min, ">=" if value >= gate.min else "<"))
    return min(limits, key=lambda limit: limit[0])


def _used(gate: Gate, value: float, bound: float) -> float | None:
    """Share of what a bound allows: of the way from the value that could not be better, where there is one.

    Without one it is value over bound; of a lower bound, which a value may pass by any amount, bound over value.
    """
    ideal = find_metric(gate.metric).ideal if gate.max_difference is None else None
    if ideal is not None and bound != ideal:
        return max((value - ideal) / (bound - ideal), 0.0)
    if bound == 0.0 or ideal is not None:
        return None
    lower = bound == gate.min and bound != gate.max
    if not lower or bound < 0.0:
        return value / bound
    return bound / value if value > 0.0 else None


def _verdict(gate: Gate, status: Status, value: MetricValue | None, reason: str) -> Verdict:
    unit = value.unit if value is not None else ""
    number = value.value if value is not None and value.valid else None
    margin = bound = used = None
    name = _name(gate)
    short = f"{name} {status}: {_printable(reason)}"
    message = short
    if number is not None and value is not None:
        margin, bound, relation = _margin(gate, number)
        used = _used(gate, number, bound)
        shown, limit = _pair(number, bound, unit)
        short = f"{name} {shown}{_suffix(unit)} {relation} {limit}"
        short += f" at t={value.t:.2f} s" if value.t is not None else ""
        short += f" ({_printable(value.object)})" if value.object else ""
        message = f"{short}, margin {_pair(margin, 0.0, unit)[0]}{_suffix(unit)}"
    place = f"{gate.file}:{gate.line}" if gate.line is not None else gate.file
    kind = "gate" if gate.only_with is None else "clean bound"
    message += f", {kind} {place}" if place else ", default gate"
    return Verdict(
        gate=_label(gate, unit),
        metric=gate.metric,
        status=status,
        value=number,
        unit=unit,
        bound=bound,
        margin=margin,
        t=value.t if value is not None else None,
        object=value.object if value is not None else "",
        message=message,
        short=short,
        file=gate.file,
        line=gate.line,
        name=name,
        used=used,
        reason="" if number is not None else _printable(reason),
        requirement=gate.requirement,
        clean=gate.only_with is not None,
    )


def _label(gate: Gate, unit: str) -> str:
    parts = []
    if gate.min is not None:
        parts.append(f">= {_pair(gate.min, gate.min, unit)[0]}")
    if gate.max is not None:
        parts.append(f"<= {_pair(gate.max, gate.max, unit)[0]}")
    if gate.max_difference is not None:
        parts.append(f"<= {_pair(gate.max_difference, gate.max_difference, unit)[0]}")
    signal = f"({gate.options['signal']})" if "signal" in gate.options and gate.between is None else ""
    name = _name(gate) if "model" in gate.options else f"{_name(gate)}{signal}"
    return f"{name} {' and '.join(parts)}{_suffix(unit)}"


def _name(gate: Gate) -> str:
    """A model's figures mean nothing without their signal and the model, and what lies between stages says so."""
    if gate.between is not None:
        signal = f"({gate.options['signal']})" if "signal" in gate.options else ""
        return _printable(f"{gate.metric}{signal}{' difference' if gate.max_difference is not None else ''}")
    if gate.only_with is not None and gate.options:  # several bounds of one metric differ by these alone
        return _printable(f"{gate.metric}({_options(gate)})")
    if "model" not in gate.options:
        return gate.metric
    model = Path(str(gate.options["model"])).name
    return _printable(f"{gate.key or gate.metric}({gate.options.get('signal', '')}, {model})")


def _suffix(unit: str) -> str:
    return "" if unit in ("-", "") else f" {unit}"


def _pair(value: float, bound: float, unit: str) -> tuple[str, str]:
    """Both numbers with as few decimals as tell them and keep them apart: a value that failed must not read like its
    bound, nor a bound of 0.002 like 0."""
    if unit == "-" and value == int(value) and bound == int(bound):
        return f"{value:.0f}", f"{bound:.0f}"
    for decimals in range(2, 7):
        one, two = f"{value:.{decimals}f}", f"{bound:.{decimals}f}"
        near = max(0.05 * abs(value), 0.02 * abs(bound))
        told = _told(one, value, near) and _told(two, bound, 0.001 * abs(bound))
        if told and (value == bound or one != two):
            return one, two
    return f"{value:.9g}", f"{bound:.9g}"


def _told(text: str, number: float, error: float) -> bool:
    """True if a text tells a number to an error, or to next to nothing."""
    return abs(float(text) - number) <= max(error, 1e-6)


def _printable(text: str) -> str:
    """Names come from a user's file and end in a terminal: no control characters."""
    return "".join(c if c.isprintable() else "?" for c in text)
