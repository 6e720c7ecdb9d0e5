"""What would the gates not notice? Each fault on each scenario, against drives without one."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.metrics import find_metric
from pytest_dvp.metrics.metric import REQUIRED
from pytest_dvp.mutation.catalogue import known_faults
from pytest_dvp.mutation.drives import Drive, Outcome
from pytest_dvp.mutation.fault import Fault
from pytest_dvp.mutation.source_mutants import SourceMutant
from pytest_dvp.verdicts.judging import default_gates

if TYPE_CHECKING:
    from pytest_dvp.workers.pool import Workers

CLEAN_SEEDS = 20  # without a fault; 20 without an alarm bound its rate by 14 % (1 - 0.05^(1/20)) at 95 % confidence
FIRST_SEED = 1  # any number does; the same each time, so that two calls agree
OF_THE_CLOCK = frozenset(("tick_time", "compute_time"))  # metrics that no log holds
SLACK = 1e-6  # of a metric's size: by less nothing has changed


@dataclasses.dataclass(frozen=True)
class Envelope:
    """A metric over the clean drives of one scenario: least and greatest value, how many, and how far they spread."""

    low: float
    high: float
    count: int

    def beyond(self, value: float) -> float:
        """By how much a value is outside, in units of the envelope's width; 0 inside."""
        outside = max(value - self.high, self.low - value)
        if outside <= SLACK * max(abs(self.low), abs(self.high), 1.0):
            return 0.0
        return outside / max(self.high - self.low, 0.01 * max(abs(self.low), abs(self.high)), 1e-3)


@dataclasses.dataclass(frozen=True)
class Proposal:
    """A gate that would have caught an escaper: metric, bound on one side, and the rate of false alarms. The bound lies
    beyond all clean drives; that the next clean one is beyond the most extreme of N happens once in N + 1 at most.
    habit: a bound on the harmless side of its metric, which clean drives keep and a better drive may break."""

    scenario: str
    metric: str
    min: float | None
    max: float | None
    false_alarm_rate: float
    habit: bool = False

    def as_dict(self) -> dict[str, Any]:
        """JSON-able."""
        return dataclasses.asdict(self)


@dataclasses.dataclass(frozen=True)
class Judged:
    """A fault over all scenarios. changed: some metric left the envelope of the clean drives; killed_by: gates that did
    not pass ("SCENARIO: GATE"); far: by how much the worst metric left its envelope; by_habit: none of these gates is a
    requirement, all are bounds of clean drives."""

    fault: Fault
    changed: bool
    killed_by: tuple[str, ...]
    far: float
    worst: str
    proposed: Proposal | None
    by_habit: bool = False

    @property
    def escaped(self) -> bool:
        """The drive was another one, and no gate said so."""
        return self.changed and not self.killed_by

    def as_dict(self) -> dict[str, Any]:
        """As `dvp mutate --json` has it."""
        return {
            "name": self.fault.name, "where": self.fault.where, "changed": self.changed,
            "killed_by": list(self.killed_by), "escaped": self.escaped, "far": self.far, "worst": self.worst,
            "proposed": self.proposed.as_dict() if self.proposed else None, "asks": self.fault.asks,
            "by_habit": self.by_habit,
        }  # fmt: skip


@dataclasses.dataclass(frozen=True)
class Mutation:
    """Result of `mutate`. unsound: gates that did not pass in clean drives, with how many; they kill nothing. met: what
    clean drives met of what faults need; reads: the sensors that the stack declares to read, None if it does not."""

    judged: tuple[Judged, ...]
    scenarios: tuple[str, ...]
    clean: int
    unsound: Mapping[str, int]
    met: frozenset[str] = frozenset()
    reads: frozenset[str] | None = None

    def why_idle(self, fault: Fault) -> str:
        """Why a fault may have changed no drive: what the stack does not read, or what no drive met; else empty."""
        if fault.of and self.reads is not None and self.reads.isdisjoint(fault.of):
            return f"your stack does not read {' or '.join(fault.of)}"
        return f"needs {fault.asks}" if fault.asks and fault.asks not in self.met else ""

    def as_dict(self) -> dict[str, Any]:
        """The document of `dvp mutate --json`."""
        return {
            "faults": [
                {**one.as_dict(), "why_idle": "" if one.changed else self.why_idle(one.fault)} for one in self.judged
            ], "scenarios": list(self.scenarios),
            "clean_seeds": self.clean, "unsound": dict(self.unsound),
        }  # fmt: skip


def mutate(
    scenarios: Sequence[Path],
    ads: str | None,
    workers: Workers,
    *,
    faults: Sequence[str] = (),
    clean: int = CLEAN_SEEDS,
    source: Sequence[SourceMutant] = (),
    reads: frozenset[str] | None = None,
) -> Mutation:
    """Drive each scenario with `clean` seeds and no fault, and once with each fault.

    ads: as `--ads` takes it, None for the reference stack; workers: those of `drive_once`; faults: names, none for all;
    source: changes of the stack's own source besides; reads: the sensors that the stack declares to read. Raises
    AdsError or ScenarioError (one line).
    """
    chosen = [known_faults()[name] for name in faults] or list(known_faults().values())
    chosen += [Fault(mutant.name, "source") for mutant in source]
    names = [str(path) for path in scenarios]
    clean_drives = {name: [Drive(name, ads=ads, seed=FIRST_SEED + k) for k in range(clean)] for name in names}
    faulty = {
        (fault.name, name): Drive(name, ads=ads, seed=FIRST_SEED, fault=fault.name)
        for fault in chosen
        for name in names
    }
    every = [*(drive for drives in clean_drives.values() for drive in drives), *faulty.values()]
    found = dict(zip(every, (Outcome(**result) for result in workers.run(every)), strict=True))
    envelopes: dict[str, dict[str, Envelope]] = {}
    unsound: dict[str, int] = {}
    for name, drives in clean_drives.items():
        outcomes = [found[drive] for drive in drives]
        envelopes[name] = envelopes_of(outcomes)
        for outcome in outcomes:
            for gate in outcome.failed:
                unsound[f"{_short(name)}: {gate}"] = unsound.get(f"{_short(name)}: {gate}", 0) + 1
    judged = tuple(
        judge_fault(fault, {name: found[faulty[fault.name, name]] for name in names}, envelopes, unsound)
        for fault in chosen
    )
    met = frozenset(need for drives in clean_drives.values() for drive in drives for need in found[drive].met)
    return Mutation(judged, tuple(names), clean, unsound, met, reads)


def envelopes_of(outcomes: Sequence[Outcome]) -> dict[str, Envelope]:
    """By metric the range of clean drives of one scenario, of metrics that each of them has.

    None of the wall clock, which differs from drive to drive by itself; none that asks for an option, for a value of
    its name alone is that of some gate's option, and no gate can be proposed of it.
    """
    found = {}
    for metric in sorted(outcomes[0].metrics.keys() - OF_THE_CLOCK):
        if REQUIRED in find_metric(metric).options.values():
            continue
        values = [outcome.metrics.get(metric) for outcome in outcomes]
        numbers = [value for value in values if value is not None]
        if len(numbers) == len(outcomes):
            found[metric] = Envelope(min(numbers), max(numbers), len(numbers))
    return found


def judge_fault(fault: Fault, outcomes: Mapping[str, Outcome], envelopes: Mapping[str, Mapping[str, Envelope]],
            unsound: Mapping[str, int]) -> Judged:  # fmt: skip
    """What a fault did over all scenarios. outcomes: of its drives, envelopes: of clean ones, both by scenario;
    unsound: gates that fail in clean drives too."""
    killed: list[str] = []
    habits: set[str] = set()
    changes: list[tuple[float, str, str, float]] = []
    gone: tuple[str, str] | None = None
    for name, outcome in outcomes.items():
        killed += [f"{_short(name)}: {gate}" for gate in outcome.failed if f"{_short(name)}: {gate}" not in unsound]
        habits |= {f"{_short(name)}: {gate}" for gate in outcome.clean}
        for metric, envelope in envelopes[name].items():
            value = outcome.metrics.get(metric)
            if value is None:
                gone = name, metric  # what every clean drive has is not defined any more
            elif (far := envelope.beyond(value)) > 0.0:
                changes.append((far, name, metric, value))
    changes.sort(reverse=True)
    proposed = None
    if not killed:
        found = [proposed_gate(name, metric, value, envelopes[name][metric]) for _, name, metric, value in changes]
        if gone is not None:
            found.append(_defined(*gone, envelopes[gone[0]][gone[1]]))
        gates = [one for one in found if one is not None]
        proposed = next((one for one in gates if not one.habit), gates[0] if gates else None)
    far, worst = (changes[0][0], f"{_short(changes[0][1])}: {changes[0][2]}") if changes else (0.0, "")
    changed = bool(changes) or gone is not None or bool(killed)
    return Judged(fault, changed, tuple(killed), far, worst, proposed, bool(killed) and habits.issuperset(killed))


def proposed_gate(scenario: str, metric: str, value: float, envelope: Envelope) -> Proposal | None:
    """The bound half way between the clean drives and the fault, or that of the default gate of the metric if that one
    is tighter; None where clean drives do not keep the default gate."""
    above = value > envelope.high
    bound = 0.5 * (value + (envelope.high if above else envelope.low))
    rate = 1.0 / (envelope.count + 1)
    for default in (gate for gate in default_gates().gates if gate.metric == metric):
        if above and default.max is not None:
            bound = min(bound, default.max)
        elif not above and default.min is not None:
            bound = max(bound, default.min)
    if bound < envelope.high if above else bound > envelope.low:
        return None
    worse = find_metric(metric).bigger_is_worse
    habit = worse is not None and worse is not above
    return Proposal(scenario, metric, None if above else bound, bound if above else None, rate, habit)


def _defined(scenario: str, metric: str, e: Envelope) -> Proposal | None:
    """A bound that clean drives keep by far, on the side that is worse: a metric that is not defined passes none."""
    away = 2.0 * max(e.high - e.low, 0.1 * max(abs(e.low), abs(e.high)), 0.01)
    return proposed_gate(
        scenario, metric, e.low - away if find_metric(metric).bigger_is_worse is False else e.high + away, e
    )


def _short(scenario: str) -> str:
    return Path(scenario).stem
