"""What a run says of traffic lights in states that say nothing of their lamps."""

from __future__ import annotations

from openscenario.findings import listed
from pytest_dvp.logs.log import Log
from vehicle.messages import is_known_state

MOST = 4  # lights that a line names


def light_notes(log: Log) -> tuple[str, ...]:
    """A line for each state of a light that no lamp is known of: neither metrics nor the reference stack heed it."""
    lights: dict[str, list[str]] = {}
    for event in log.events:
        if event.kind == "signal" and not is_known_state(event.text):
            lights.setdefault(event.text, []).append(event.element)
    return tuple(
        f"light {listed(list(dict.fromkeys(names)), MOST)}: the state {state[:40]!r} says of no lamp that it is lit, "
        "and stops nobody; known are red, amber, green, lamps as on;off;off, flashing and off"
        for state, names in lights.items()
    )
