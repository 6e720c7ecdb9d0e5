"""Gates with a bound on the harmless side alone: they pass a worse drive and fail a better one, mostly a slip."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from openscenario.findings import Finding
from pytest_dvp.metrics import MetricError, find_metric
from pytest_dvp.verdicts.gate import Gate


def on_the_harmless_side(gates: Sequence[Gate]) -> Iterator[Finding]:
    """A warning for each gate whose only bound is a `min` where bigger is worse, or a `max` where smaller is worse.

    None where another gate bounds the same on the other side, none for a metric of which neither direction is worse,
    and none for a bound of clean drives, which is meant so.
    """
    for gate in gates:
        side = _lone_side(gate)
        if side is None or gate.only_with is not None or any(_completes(other, gate, side) for other in gates):
            continue
        other, worse = ("max", "bigger") if side == "min" else ("min", "smaller")
        bound = gate.min if side == "min" else gate.max
        yield Finding(
            "dvp.gates.harmless_side",
            "warning",
            gate.file,
            gate.line,
            f"gate.{side}",
            text=f"{worse} {gate.metric} is worse; {side} = {bound:g} alone passes worse drives and fails better ones",
            allowed=f"{other}, or both",
            hint=f"did you mean {other} = {bound:g}?",
        )


NOTE = "one-sided gate: "  # how the note of a run begins, so that judging anew can replace it


def harmless_notes(gates: Sequence[Gate]) -> list[str]:
    """The same as notes of a run, one line each."""
    return [f"{NOTE}{one.file}:{one.line}: {one.message}" for one in on_the_harmless_side(gates)]


def _completes(other: Gate, gate: Gate, side: str) -> bool:
    """Whether another gate bounds the same metric on the side that this one leaves open, wherever this one applies."""
    same = (other.metric, other.options, other.between) == (gate.metric, gate.options, gate.between)
    bound = other.max if side == "min" else other.min
    return same and bound is not None and other.only_with is None and set(gate.stages) <= set(other.stages)


def _lone_side(gate: Gate) -> str | None:
    """The side of the only bound where it is the harmless one."""
    try:
        bigger_is_worse = find_metric(gate.metric).bigger_is_worse
    except MetricError:  # a gate that was built in Python: judging says what is wrong with it
        return None
    if bigger_is_worse and gate.max is None and gate.min is not None:
        return "min"
    if bigger_is_worse is False and gate.min is None and gate.max is not None:
        return "max"
    return None
