"""A run that could start now."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

from openscenario.model.scenario import Scenario
from openscenario.road.network import RoadNetwork
from openscenario.storyboard.engine import Storyboard
from pytest_dvp.drive.ego_task import EgoTask
from pytest_dvp.drive.guard_log import GuardLog
from pytest_dvp.drive.target_reference import TargetReference
from pytest_dvp.drive.world import World
from pytest_dvp.logs.recorder import LogRecorder
from pytest_dvp.verdicts.judging import GateFile
from vehicle.adapter import Vehicle
from vehicle.messages import FloatArray

if TYPE_CHECKING:
    from pytest_dvp.drive.driver import Driver


@dataclasses.dataclass(frozen=True)
class Ready:
    """A run that could start now."""

    scenario: Scenario
    network: RoadNetwork
    gates: GateFile
    ego: str
    task: EgoTask
    storyboard: Storyboard
    world: World
    vehicle: Vehicle
    driver: Driver
    recorder: LogRecorder
    first_row: FloatArray  # (1, 12) TRACE_COLUMNS at t = 0
    gate_log: GuardLog = dataclasses.field(default_factory=GuardLog)  # of stages pe and rw
    targets: TargetReference | None = None  # what measures the road users for the log; None: it holds the truth

    def close(self) -> None:
        """Close vehicle, world and driver."""
        self.vehicle.close()
        self.world.close()
        self.driver.close()
