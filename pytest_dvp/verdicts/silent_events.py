"""Events of a storyboard that never fired: what a verdict says of them, and which ones a test lets be.

Plain dicts as `RunResult.as_dict` makes them. Imports the standard library only: it is loaded with the plugin.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping, Sequence
from typing import Any

from pytest_dvp.logs.event_reference import means_event
from pytest_dvp.text.errors import SettingError
from pytest_dvp.text.printable import clean
from pytest_dvp.text.spelling import nearest

STORYBOARD = "storyboard"  # the gate that the verdict on such events names
COUNTED = "events_fired"  # the metric whose gates decide on them
SHOWN = 3  # names in one text


def is_of_events(verdict: Mapping[str, Any]) -> bool:
    """Whether a verdict says that events never fired: no choice of metrics leaves it out."""
    return verdict["metric"] == COUNTED or (not verdict["metric"] and verdict["gate"] == STORYBOARD)


def check_optional(optional: Collection[str], names: Sequence[str], option: str = "optional_events") -> None:
    """Raises SettingError with the nearest name for an event that a storyboard with these events does not have."""
    if isinstance(optional, str):
        raise SettingError(f"{option}: found {optional!r}, expected a list of names: {option}=[{optional!r}]")
    for reference in optional:
        if any(means_event(reference, name) for name in names):
            continue
        near = nearest(reference, {name.rpartition("::")[2] for name in names} | set(names))
        has = f"it has: {', '.join(names)}" if names else "it has none"
        told = f"did you mean {near!r}?" if near else has
        raise SettingError(f"{option}: the scenario has no storyboard event {reference!r}; {told}")


def storyboard_verdict(silent: Sequence[str], count: int) -> dict[str, Any]:
    """The fields of the INCONCLUSIVE verdict on events that never fired, of `count` in the scenario."""
    which = ", ".join(repr(clean(name)) for name in silent[:SHOWN]) + (", ..." if len(silent) > SHOWN else "")
    many = f"{len(silent)} of {count} events never fired: " if len(silent) > 1 else "event "
    short = f"{STORYBOARD} INCONCLUSIVE: {many}{which}{' never fired' if len(silent) == 1 else ''}"
    listed = json.dumps(list(silent[:SHOWN]))
    message = (
        f"{short}; if that is meant: optional_events={listed} in the test's gate(), "
        f"or a gate on {COUNTED} with max = 0 and optional = {listed}"
    )
    fields = dict.fromkeys(("value", "bound", "margin", "t", "line", "used"))
    texts = dict.fromkeys(("metric", "unit", "object", "file", "name", "reason"), "")
    return {
        **fields,
        **texts,
        "gate": STORYBOARD,
        "status": "INCONCLUSIVE",
        "message": clean(message),
        "short": short,
    }


def without_optional(result: Mapping[str, Any], optional: Collection[str]) -> dict[str, Any]:
    """The result as a test judges it that lets these events be: they are missed neither by the storyboard nor a gate.

    Names that the scenario does not have change nothing: `check_optional` tells them.
    """
    silent = [name for name in result.get("never_fired", ()) if not any(means_event(one, name) for one in optional)]
    let_be = len(result.get("never_fired", ())) - len(silent)
    if not let_be:
        return dict(result)
    verdicts = []
    for verdict in result["verdicts"]:
        if verdict["metric"] == COUNTED and verdict["status"] == "INCONCLUSIVE" and verdict["value"] is not None:
            verdicts.append(_fewer(verdict, let_be, silent))
        elif verdict["metric"] or verdict["gate"] != STORYBOARD:
            verdicts.append(verdict)
        elif silent:
            verdicts.append(storyboard_verdict(silent, len(result.get("events", ()))))
    from pytest_dvp.verdicts.statuses import worst_status  # it needs `reports`, which no session without a run may load

    status = worst_status(verdicts) if verdicts else "INCONCLUSIVE"
    return {**result, "verdicts": verdicts, "never_fired": silent, "status": status}


def missed(result: Mapping[str, Any]) -> dict[str, Any] | None:
    """The verdict on events that never fired, None if all did or a gate on `events_fired` decides on them."""
    silent = result.get("never_fired", ())
    if not silent or any(is_of_events(verdict) for verdict in result["verdicts"]):
        return None
    return storyboard_verdict(silent, len(result.get("events", ())))


def _fewer(verdict: Mapping[str, Any], let_be: int, silent: Sequence[str]) -> dict[str, Any]:
    """A verdict on `events_fired` of which `let_be` events do not count."""
    value, bound = verdict["value"] - let_be, verdict["bound"]
    if value > bound:
        return {**verdict, "value": value, "margin": bound - value, "object": silent[0] if silent else ""}
    short = f"{COUNTED} {value:.0f} <= {bound:.0f}"
    told = {"short": short, "message": f"{short}, margin {bound - value:.0f}", "object": ""}
    return {**verdict, **told, "status": "PASS", "value": value, "margin": bound - value}
