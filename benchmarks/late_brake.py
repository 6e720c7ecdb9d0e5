"""A stack of ten lines with a planted rare fault: it brakes by the clock, whatever is ahead."""

from __future__ import annotations

from vehicle.messages import Command, Observation

BRAKES = 2.8  # s; late only for a fast car behind a slow one that is near: 0.5 to 1 % of the ranges of follow.xosc
LATER = 3.4  # s; of 400 even drives each 3 failed with 3.2, 4 with 3.4, 8 with 3.7


class LateBrake:
    """Straight ahead with little throttle, then the brake."""

    brakes = BRAKES

    def tick(self, observation: Observation) -> Command:
        """The command of this moment."""
        late = observation.t > self.brakes
        return Command(observation.t, steer=0.0, accel=0.0, throttle=0.0 if late else 0.1, brake=0.5 if late else 0.0)


class LaterBrake(LateBrake):
    """The same a little later, so that about one variant of a hundred fails."""

    brakes = LATER


class TenLines(LateBrake):
    """The same without the fault, for the cost of a drive: it drives on."""

    reads: tuple[str, ...] | None = ()

    def tick(self, observation: Observation) -> Command:
        """The command of this moment."""
        return Command(observation.t, steer=0.0, accel=0.0, throttle=0.1, brake=0.0)


class AllSensors(TenLines):
    """The same as a stack that does not say which sensors it reads: all are simulated."""

    reads = None
