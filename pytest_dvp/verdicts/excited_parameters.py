"""What two drives could validate: a gate speaks for the parameters that it lists, as far as the drives excited them.

A twin that is wrong in its brake fade agrees with the car on a drive that never brakes. Such a gate does not pass for
`parameters = ["brake_fade"]`; for the parameters that no gate lists, what the drives could not show is said beside it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from typing import Any

from pytest_dvp.logs.log import Log
from pytest_dvp.text.spelling import unknown
from pytest_dvp.verdicts.gate import Gate, Stage


def wrong_parameters(value: object) -> str:
    """What is wrong with `parameters` of a gate between stages; empty if nothing is."""
    if not isinstance(value, list) or not value or not all(isinstance(name, str) for name in value):
        return 'parameters must be a list of effects or their keys, parameters = ["steer_delay", "brake_gain.g"]'
    return next((text for name in value if (text := _unknown(name))), "")


def unexcited(gate: Gate, logs: Mapping[str, Log]) -> str:
    """Which of a gate's `parameters` one of its two drives did not excite, what it lacked and what would show them: one
    line, "" if there is none."""
    if not gate.parameters or gate.between is None:
        return ""
    lacking = _lacking(logs[stage] for stage in gate.between)
    missed = [(name, effect) for name in gate.parameters if (effect := name.partition(".")[0]) in lacking]
    if not missed:
        return ""
    told = "; ".join(f"{name} ({lacking[effect]}; drive: {_shown_by(effect)['manoeuvre']})" for name, effect in missed)
    command = _command([effect for _, effect in missed])
    return f"within its bound, but these drives do not excite {told}" + (f": {command}" if command else "")


def not_validated(
    gates: Iterable[Gate], pairs: Iterable[tuple[Stage, Stage]], logs: Mapping[str, Log]
) -> list[dict[str, Any]]:
    """Effects that drives of these pairs could not show and that no gate lists, as result.json holds them.

    Each has `between`, `parameter`, `needs` (what the drive lacked), `manoeuvre` (what would show it) and `command`
    (the `dvp plan` that finds that; empty for an effect of perception, which no manoeuvre of the car alone shows).
    """
    listed = {name.partition(".")[0] for gate in gates for name in gate.parameters}
    found = []
    for pair in pairs:
        if not all(stage in logs for stage in pair):
            continue
        for name, needs in _lacking(logs[stage] for stage in pair).items():
            if name not in listed:
                found.append({"between": list(pair), "parameter": name, "needs": needs, **_shown_by(name)})
    return found


def _lacking(logs: Iterable[Log]) -> dict[str, str]:
    """What each effect would have needed that one of the drives lacked, by name, in the catalogue's order."""
    from pytest_dvp.doctor.excitation import excitation

    found: dict[str, str] = {}
    for log in logs:
        shown = excitation(log)
        for name, needs in {**shown.out_of_reach, **shown.hardly}.items():
            found.setdefault(name, needs)
    return found


def _shown_by(effect: str) -> dict[str, str]:
    from vehicle.model.effect_catalogue import find_effect

    return {"manoeuvre": find_effect(effect).reveals, "command": _command([effect])}


def _command(effects: Sequence[str]) -> str:
    """The command that plans what excites these; "" if they are all of perception."""
    from vehicle.model.effect_catalogue import perception_effect_names

    moved = [name for name in dict.fromkeys(effects) if name not in perception_effect_names()]
    return f"dvp plan --model MODEL.toml --excite {','.join(moved)}" if moved else ""


@cache
def _unknown(name: str) -> str:
    from vehicle.model.effect_catalogue import catalogue

    effect, dot, key = name.partition(".")
    if effect not in catalogue():
        return f"{unknown('effect', effect, catalogue())} (dvp effects lists them)"
    keys = [k.name for k in catalogue()[effect].parameters]
    return unknown(f"key of {effect}", key, keys) if dot and key not in keys else ""
