"""A real car whose guard runs in a process of its own (`host.py`), which alone reaches the car.

    car = GateProcess(Opening("my_package:Tabby", "7", ...), record=log.append, trouble=wire_log.append)

Used as `vehicle.guard.guarded_vehicle.GuardedVehicle` is. The process does not outlive this one; if it dies or hangs
the car must stop by itself, as it must whenever 100 ms pass without a command.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any, NoReturn

from vehicle.adapter import VehicleLost
from vehicle.child_process import own_module, own_path
from vehicle.guard.guard import ArmingRefused
from vehicle.guard.messages import Arming, Decision
from vehicle.guard.process_messages import Answer, Keys, Opened, Opening, Untold, pack, unpack
from vehicle.interpreter_bridge import Bridge
from vehicle.messages import Command, FloatArray, Observation, Surroundings, VehicleDescription, VehicleState
from vehicle.wire.health import Trouble

RAISED = {kind.__name__: kind for kind in (VehicleLost, ArmingRefused, ValueError)}
OPEN, ANSWER = 90.0, 10.0  # s of wall time until the car is there, and for an answer
SILENT = 5.0  # s without a beat: what compiles or loads in it on a busy machine holds them up
WHO = "the guard"


class GuardProcess:
    """The car that `opening` describes. `record` gets every decision of its gate, `trouble` every one of its messages.

    Raises VehicleLost if the car or the process does not come.
    """

    needs_keys = True

    def __init__(
        self, opening: Opening, *, record: Callable[[Decision], None], trouble: Callable[[Trouble], None]
    ) -> None:
        self._record, self._trouble = record, trouble
        self._number, self._armed = 0, False
        self._over: dict[str, Any] = {}
        self._sigma = math.nan
        host = own_module("vehicle.guard.host")[1:]  # the bridge names Python itself
        self._bridge: Bridge | None = Bridge(
            who=WHO, error=VehicleLost, environment=own_path(), server=host, silent=SILENT
        )
        try:
            self._opened: Opened = unpack(self._ask("open", pack(opening), OPEN), Opened)
        except BaseException:
            self.close()
            raise

    @property
    def pid(self) -> int:
        """Of the process."""
        return self._wire().pid

    @property
    def description(self) -> VehicleDescription:
        """The car's."""
        return self._opened.description

    @property
    def is_real(self) -> bool:
        """The car's."""
        return self._opened.is_real

    @property
    def position_sigma(self) -> float:
        """The car's [m], as of the last answer."""
        return self._sigma

    @property
    def armed(self) -> bool:
        """False in a dry run: nothing reaches the actuators."""
        return self._armed

    def reset(self, state: VehicleState, *, named: str | None = None, arming: Arming | None = None) -> None:
        """As of Gated. Raises ArmingRefused."""
        self._do("reset", (state, Keys(named, arming)), None, 2.0 * ANSWER)  # one that is armed is reset twice

    def arm(self, named: str | None = None, arming: Arming | None = None) -> None:
        """As of Gated. Raises ArmingRefused."""
        self._do("arm", Keys(named, arming), None)

    def emergency_stop(self) -> None:
        """Latch the stop profile from the next cycle on."""
        self._do("emergency_stop", None, None)

    def observe(self, surroundings: Surroundings) -> Observation:
        """The car's sensors."""
        seen: Observation = self._do("observe", surroundings, Observation)
        return seen

    def apply(self, command: Command, sequence: int | None = None) -> None:
        """Ask the gate; what it decides goes to the car."""
        self._do("apply", (command, sequence), None)

    def step(self, dt: float) -> FloatArray:
        """Let `dt` [s] pass. Returns the motion since the last call, rows of TRACE_COLUMNS. Their shape is (n, 12)."""
        rows: FloatArray = self._do("step", dt, FloatArray)
        return rows

    def stop(self) -> None:
        """Bring the car to a halt, if it is armed; one that is lost is asked nothing."""
        if self._bridge is not None:
            self._do("stop", None, None)

    def close(self) -> None:
        """Let go of the car, and end the process. How punctual it was is known before and after."""
        bridge = self._bridge
        if bridge is None:
            return
        try:
            self._over = self.punctuality()
            self._ask("close", b"", ANSWER)
        except (VehicleLost, ValueError):
            pass  # it has let go already
        self._bridge = None
        bridge.close()

    def punctuality(self) -> dict[str, Any]:
        """How punctual the car was in this run, if it tells."""
        if self._bridge is None:
            return self._over
        try:
            told: dict[str, Any] = self._do("punctuality", None, dict[str, Any])
        except ValueError:  # whatever the car was lost by: see RAISED
            return {}
        return told

    def _wire(self) -> Bridge:
        if self._bridge is None:
            raise VehicleLost("the vehicle is closed")
        return self._bridge

    def _do(self, what: str, given: Any, kind: Any, answer: float = ANSWER) -> Any:
        got: Answer = unpack(self._ask(what, pack(given), answer), Answer)
        self._armed, self._sigma = got.armed, got.position_sigma
        self._hear(got.untold)
        return unpack(got.value, kind)

    def _hear(self, untold: Untold) -> None:
        for decision in untold.decisions:
            self._record(decision)
        for trouble in untold.troubles:
            self._trouble(trouble)

    def _ask(self, what: str, given: bytes, answer: float) -> bytes:
        bridge = self._wire()
        self._number += 1
        bridge.send({"n": self._number, "do": what}, given)
        deadline = time.monotonic() + answer
        while True:
            for head, body in bridge.receive(0.02):
                if head["n"] != self._number:
                    continue  # of a question that was interrupted
                if "error" in head:
                    if body:
                        self._hear(unpack(body, Untold))
                    self._raise(head["error"], head["text"])
                return body
            if time.monotonic() > deadline:
                raise VehicleLost(f"{WHO} did not answer within {answer:g} s")

    def _raise(self, kind: str, text: str) -> NoReturn:
        raise RAISED.get(kind, VehicleLost)(text if kind in RAISED else f"{WHO}'s process: {kind}: {text}")
