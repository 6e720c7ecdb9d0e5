"""Names of the scenario that a gate file uses: events of its storyboard, and its entities."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from openscenario.findings import Finding, listed, nearest
from openscenario.model.scenario import Scenario
from pytest_dvp.logs.event_names import EventNames
from pytest_dvp.logs.event_reference import means_event
from pytest_dvp.verdicts.gate import Gate, GateFile
from pytest_dvp.verdicts.gate_file_lines import locate_lines
from pytest_dvp.verdicts.silent_events import COUNTED

EVENTS = {"event_started": "event", COUNTED: "optional"}
"""The option of a metric that names events, one or several."""

ENTITY = "object."
"""How a signal begins that is of an entity: `object.NAME.x`."""


def unknown_names(gates: GateFile, scenario: Scenario, file: str) -> Iterator[Finding]:
    """Findings of the names in a gate file that the scenario, of this file name, does not have.

    An event is one of the storyboard, or it can never fire. An entity may also appear while the scenario runs, as the
    vehicles of a traffic swarm do: a name is an error only where it is nearly that of an entity, else a warning.
    """
    events = list(EventNames(scenario))
    short = {name.rpartition("::")[2] for name in events}
    entities = [entity.name for entity in scenario.entities]
    for number, gate in enumerate(gates.gates, start=1):
        for option, name in _events(gate):
            if not any(means_event(name, event) for event in events):
                yield Finding(
                    "dvp.gates.unknown_event",
                    "error",
                    gates.file,
                    _line(gate, option),
                    f"gate[{number}].{option}",
                    text=f"{file} has no storyboard event of this name",
                    found=name,
                    allowed=listed(events) or "none, it has no events",
                    hint=nearest(name, {*short, *events}),
                )
        entity = _entity(gate)
        if entity is not None and entity not in entities:
            near = nearest(entity, entities)
            yield Finding(
                "dvp.gates.unknown_entity",
                "error" if near else "warning",
                gates.file,
                _line(gate, "signal"),
                f"gate[{number}].signal",
                text=f"{file} has no entity of this name",
                found=entity,
                allowed=listed(entities),
                hint=near,
            )


def _events(gate: Gate) -> Iterator[tuple[str, str]]:
    """(option, name) of each event that a gate names."""
    option = EVENTS.get(gate.metric)
    named = gate.options.get(option, ()) if option is not None else ()
    for name in (named,) if isinstance(named, str) else named:
        yield str(option), str(name)


def _entity(gate: Gate) -> str | None:
    """The entity of whose motion a gate is."""
    signal = str(gate.options.get("signal", ""))
    return signal.removeprefix(ENTITY).rpartition(".")[0] if signal.startswith(ENTITY) else None


def _line(gate: Gate, option: str) -> int | None:
    """The line of the option; that of the gate where its file is gone by now."""
    try:
        lines = locate_lines(Path(gate.file).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError):
        return gate.line
    return next((keys.get(option, head) for head, keys in lines.gates if head == gate.line), gate.line)
