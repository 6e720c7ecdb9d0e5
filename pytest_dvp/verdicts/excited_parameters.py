"""What two drives could validate: a gate speaks for the parameters that it lists, as far as the drives excited them.

A twin that is wrong in its brake fade agrees with the car on a drive that never brakes. Such a gate does not pass for
`parameters = ["brake_fade"]`; for the parameters that no gate lists, what the drives could not show is said beside it.
`"model"` in that list stands for all that the twin claims without evidence: the effects of its model file that were not
fitted on a log, and those of its parameters that no data sheet prints and that are not at their defaults.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from typing import Any

from pytest_dvp.logs.log import Log
from pytest_dvp.text.spelling import unknown
from pytest_dvp.verdicts.gate import Gate, Stage
from pytest_dvp.verdicts.idle_claims import idle_claims

MODEL = "model"
IDLE_HERE = "without it the twin answers this drive's commands alike"
UNPRINTED = {
    "yaw_inertia": "yaw_inertia",
    "cornering_stiffness_front": "understeer",
    "cornering_stiffness_rear": "understeer",
    "cg_height": "load_transfer",
    "command_mass": "mass",
}
"""Parameters of a model file that a manufacturer does not print, and the effect whose manoeuvre shows each of them."""


def wrong_parameters(value: object) -> str:
    """What is wrong with `parameters` of a gate between stages; empty if nothing is."""
    if not isinstance(value, list) or not value or not all(isinstance(name, str) for name in value):
        return (
            'parameters must be a list of effects, their keys or "model", parameters = ["steer_delay", "brake_gain.g"]'
        )
    return next((text for name in value if (text := _unknown(name))), "")


def unexcited(gate: Gate, logs: Mapping[str, Log]) -> str:
    """Which of a gate's `parameters` one of its two drives did not excite, what it lacked and what would show them: one
    line, "" if there is none."""
    if not gate.parameters or gate.between is None:
        return ""
    lacking = _lacking(logs[stage] for stage in gate.between)
    twin, measured = (logs[stage] for stage in gate.between)
    claimed = _claimed(twin) if MODEL in gate.parameters else {}
    if claimed:
        lacking = {**dict.fromkeys(idle_claims(twin, measured), IDLE_HERE), **lacking}
    asked = {name: name.partition(".")[0] for name in gate.parameters if name != MODEL} | claimed
    missed = [(name, effect) for name, effect in asked.items() if effect in lacking]
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
    gates = list(gates)
    listed = {name.partition(".")[0] for gate in gates for name in gate.parameters}
    for gate in gates:
        if MODEL in gate.parameters and gate.between is not None and gate.between[0] in logs:
            listed |= set(_claimed(logs[gate.between[0]]).values())
    found = []
    for pair in pairs:
        if not all(stage in logs for stage in pair):
            continue
        for name, needs in _lacking(logs[stage] for stage in pair).items():
            if name not in listed:
                found.append({"between": list(pair), "parameter": name, "needs": needs, **_shown_by(name)})
    return found


def _claimed(log: Log) -> dict[str, str]:
    """What the twin of a log claims beyond data sheet and logs: by its name, the effect whose manoeuvre shows it."""
    from vehicle.model.car import make_car
    from vehicle.model.errors import ModelError
    from vehicle.model.model_file import parse_model

    about = log.meta.get("model")
    text = about.get("toml") if isinstance(about, dict) else None
    try:
        model = parse_model(text) if isinstance(text, str) else None
    except ModelError:  # of an effect that only its own project has
        return {}
    if model is None:
        return {}
    values = model.car.values()
    usual = make_car({name: value for name, value in values.items() if name not in UNPRINTED}).values()
    apart = {name: effect for name, effect in UNPRINTED.items() if values[name] != usual[name]}
    return {applied.name: applied.name for applied in model.effects if not applied.fitted_on} | apart


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
    if name == MODEL:
        return ""
    if effect not in catalogue():
        return f"{unknown('effect', effect, catalogue())} (dvp effects lists them)"
    keys = [k.name for k in catalogue()[effect].parameters]
    return unknown(f"key of {effect}", key, keys) if dot and key not in keys else ""
