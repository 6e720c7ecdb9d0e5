"""The process that holds a real car and the guard before it:  python -m vehicle.guard.host FD

Nobody else reaches the car. The harness asks (`process.py`): reset, observe, apply, step ...; while it says
nothing, the gate goes on by itself, 50 cycles a second by the wall clock, so that a stack that hangs, or a harness that
is stopped, has the car braked within 100 ms and a cycle. What the car did meanwhile comes with the next steps.
"""

from __future__ import annotations

import gc
import importlib
import sys
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

import msgspec
import numpy as np

from vehicle.adapter import KnowsItsMap, ReportsMessageFaults, Vehicle
from vehicle.guard.guard import CYCLE
from vehicle.guard.guarded_vehicle import GuardedVehicle, limits_of
from vehicle.guard.messages import Decision
from vehicle.guard.process_messages import Answer, Keys, Opened, Opening, Untold, pack, unpack
from vehicle.interpreter_server import Wire
from vehicle.messages import Command, FloatArray, Observation, Surroundings, VehicleState
from vehicle.wire.health import Trouble

SAME = 1e-9  # s


class Host:
    """The car that `opening` describes, behind the gate. Raises what the adapter raises."""

    def __init__(self, opening: Opening) -> None:
        self._decisions: list[Decision] = []
        self._troubles: list[Trouble] = []
        self._driving = False
        module, _, name = opening.adapter.partition(":")
        adapter = getattr(importlib.import_module(module), name)(opening.argument)
        if not isinstance(adapter, Vehicle):
            what = type(adapter).__name__
            raise ValueError(f"vehicle {opening.name!r}: {what} is no Vehicle (vehicle.adapter.Vehicle)")
        if isinstance(adapter, ReportsMessageFaults):
            adapter.tell(self._troubles.append)
        if isinstance(adapter, KnowsItsMap):
            adapter.locate_map(opening.origin, opening.why_not)
        self._punctuality: Callable[[], Any] = lambda: getattr(adapter, "punctuality", None)
        car: Vehicle = adapter
        if opening.parallel:
            from vehicle.adapters.mirror import in_parallel
            from vehicle.model.effect_catalogue import find_effect
            from vehicle.model.vehicle_model import AppliedEffect

            seen_with = [AppliedEffect(find_effect(name), values) for name, values in opening.perception.items()]
            among = in_parallel(adapter, opening.seed, seen_with)
            among.warm_up()
            car = among
        limits = limits_of(car.description, max_speed=opening.max_speed, area=opening.area)
        self._gated = GuardedVehicle(
            car, limits, name=opening.name, scenario=opening.scenario, record=self._decisions.append
        )
        self._ahead, self._due = 0.0, 0.0  # s that the gate has gone on by itself; when (monotonic) it is to again
        self._t = 0.0  # the harness's time
        self._rows: list[FloatArray] = []

    @property
    def opened(self) -> Opened:
        """What the harness is told first."""
        return Opened(self._gated.description, self._gated.is_real)

    def wait(self) -> float | None:
        """Time [s] until the gate is to go on by itself; None: the car is not driven."""
        return max(0.0, self._due - time.monotonic()) if self._driving else None

    def go_on(self) -> None:
        """A cycle without the harness."""
        self._rows.append(self._gated.step(CYCLE))
        self._ahead += CYCLE
        self._due = time.monotonic() + CYCLE

    def answer(self, what: str, given: bytes) -> Answer:
        """The answer to a question. Raises what the car or the gate raises."""
        value = pack(self._asked[what](self, given))
        return Answer(msgspec.Raw(value), self.untold(), self._gated.armed, self._gated.position_sigma)

    def untold(self) -> Untold:
        """What the harness has not been told yet; once."""
        untold = Untold(tuple(self._decisions), tuple(self._troubles))
        self._decisions.clear()
        self._troubles.clear()
        return untold

    def close(self, given: bytes = b"") -> None:
        """Let go of the car, which stops by itself."""
        self._driving = False
        self._gated.close()

    def _reset(self, given: bytes) -> None:
        state, keys = unpack(given, tuple[VehicleState, Keys])
        self._driving = False
        gc.collect()
        gc.disable()  # a collection takes longer than a cycle
        self._gated.reset(state, named=keys.named, arming=keys.arming)
        self._t, self._ahead, self._rows = state.t, 0.0, []

    def _arm(self, given: bytes) -> None:
        keys = unpack(given, Keys)
        self._gated.arm(keys.named, keys.arming)

    def _observe(self, given: bytes) -> Observation:
        seen = self._gated.observe(unpack(given, Surroundings))
        return msgspec.structs.replace(seen, t=self._t)

    def _apply(self, given: bytes) -> None:
        command, sequence = unpack(given, tuple[Command, int | None])
        self._gated.apply(command, sequence)

    def _step(self, given: bytes) -> FloatArray:
        dt = unpack(given, float)
        left = dt - self._ahead
        if left > SAME:
            self._rows.append(self._gated.step(left))
        self._ahead = max(0.0, -left) if left < -SAME else 0.0
        self._t = round(self._t + dt, 9)
        rows, self._rows = self._rows, []
        self._driving, self._due = True, time.monotonic() + CYCLE
        return np.concatenate([np.zeros((0, 12)), *rows])

    def _stop(self, given: bytes) -> None:
        self._driving = False
        self._gated.stop()

    def _emergency_stop(self, given: bytes) -> None:
        self._gated.emergency_stop()

    def _told(self, given: bytes) -> dict[str, float | int | str]:
        kept = self._punctuality()
        return {} if kept is None else dict(getattr(kept, "as_dict", kept)())

    _asked: Mapping[str, Callable[[Any, bytes], Any]] = {
        "reset": _reset,
        "arm": _arm,
        "observe": _observe,
        "apply": _apply,
        "step": _step,
        "stop": _stop,
        "emergency_stop": _emergency_stop,
        "punctuality": _told,
        "close": close,
    }


def serve(wire: Wire) -> None:
    """Answer until the harness closes the socket; ends the process then."""
    ask, body = wire.read()
    host: Host | None = None
    lost: Exception | None = None
    while True:
        try:
            if host is None:
                host = Host(unpack(body, Opening))
                value = pack(host.opened)
            elif lost is not None:
                raise lost
            else:
                value = pack(host.answer(ask["do"], body))
            wire.write({"n": ask["n"]}, value)
        except Exception as error:  # the harness's to judge
            told = {"n": ask["n"], "error": type(error).__name__, "text": " ".join(str(error).split())[:500]}
            wire.write(told, b"" if host is None else pack(host.untold()))
        while host is not None and not wire.waits(host.wait()):
            try:
                host.go_on()
            except Exception as error:  # told with the next question
                host.close()
                lost = error
        ask, body = wire.read()


def main() -> None:
    """Serve the socket of the command line."""
    wire = Wire(int(sys.argv[1]))
    threading.Thread(target=wire.beat, daemon=True).start()
    serve(wire)


if __name__ == "__main__":
    main()
