"""Programs of traffic lights: phases one after another, round and round.

Source: ASAM OpenSCENARIO XML 1.3, classes TrafficSignalController, Phase: the first phase begins with the simulation,
or `delay` seconds after that of the controller that `reference` names; after the last phase comes the first again.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from openscenario import model
from openscenario.storyboard.unsupported import Unsupported
from openscenario.storyboard.world import World

ROUNDING = 1e-9  # s


class Program:
    """A controller under way. `start` [s]: when its first phase began, or virtually did."""

    __slots__ = ("_period", "_phases", "_shown", "name", "start")

    def __init__(self, controller: model.TrafficSignalController, start: float) -> None:
        self.name = controller.name
        self._phases = controller.phases
        self._period = sum(phase.duration for phase in controller.phases)
        self._shown: model.Phase | None = None
        self.start = start

    def names(self) -> tuple[str, ...]:
        """The names of the phases, in their order."""
        return tuple(phase.name for phase in self._phases)

    def phase(self, time: float) -> model.Phase | None:
        """The phase at `time` [s]; None of a controller without any."""
        if not self._phases:
            return None
        if self._period <= 0.0 or not math.isfinite(self._period):
            return self._phases[0]
        left = (time - self.start + ROUNDING) % self._period
        for phase in self._phases:
            if left < phase.duration:
                return phase
            left -= phase.duration
        return self._phases[-1]

    def begin(self, name: str, time: float) -> None:
        """Go on from the beginning of the phase called `name`."""
        before = 0.0
        for phase in self._phases:
            if phase.name == name:
                break
            before += phase.duration
        self.start = time - before
        self._shown = None

    def show(self, time: float, world: World) -> None:
        """Set the lights where a new phase has begun; between, actions may set them otherwise."""
        phase = self.phase(time)
        if phase is None or phase is self._shown:
            return
        self._shown = phase
        for each in phase.traffic_signal_states:
            world.show(each.traffic_signal_id, each.state)


def programs(controllers: Sequence[model.TrafficSignalController]) -> dict[str, Program]:
    """Controller name -> its program, with the delays against each other."""
    named = {each.name: each for each in controllers}

    def start(controller: model.TrafficSignalController, seen: frozenset[str]) -> float:
        other = named.get(controller.reference)
        if other is None or other.name in seen:
            return controller.delay
        return controller.delay + start(other, seen | {other.name})

    return {name: Program(each, start(each, frozenset((name,)))) for name, each in named.items()}


def program_with(known: Mapping[str, Program], controller: str, phase: str) -> Program:
    """The program of `controller`, which has a phase of that name.

    Raises:
        Unsupported: no such controller, or it has no such phase.
    """
    program = known.get(controller)
    if program is None:
        raise Unsupported("no traffic signal controller of this name", controller, ", ".join(known))
    if phase not in program.names():
        raise Unsupported("the controller has no such phase", phase, ", ".join(program.names()))
    return program
