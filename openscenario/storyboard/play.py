"""Play: the storyboard alone, all entities moved by it, no driving stack; rows for a table."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from openscenario import model
from openscenario.findings import Finding
from openscenario.road.network import RoadNetwork
from openscenario.storyboard.engine import Storyboard
from openscenario.storyboard.nodes import Transition
from openscenario.storyboard.plausibility import CODE, Plausibility, said_of
from openscenario.storyboard.reading import USUAL, Reading

ROW_STEP = 0.05  # s


class Row(NamedTuple):
    """Pose of one entity's reference point: time [s], x, y [m], h [rad, 0 to 2 pi), speed [m/s]."""

    time: float
    entity: str
    x: float
    y: float
    h: float
    speed: float


class Played(NamedTuple):
    """What a storyboard did: rows at multiples of 0.05 s, entities in file order, then
    traffic as it came; transitions; doubts afterwards; monitors at the end; `implausible`:
    the motions that no entity could make, as in `Plausibility.findings`."""

    rows: list[Row]
    transitions: list[Transition]
    findings: tuple[Finding, ...]
    stopped: bool
    time: float
    monitors: Mapping[str, bool] = MappingProxyType({})
    implausible: tuple[Mapping[str, Any], ...] = ()


def play(
    scenario: model.Scenario,
    network: RoadNetwork | None,
    dt: float = 0.01,
    duration: float = 60.0,
    *,
    seed: int = 0,
    reading: Reading = USUAL,
) -> Played:
    """Run a scenario until its stop trigger or for `duration` [s], in steps of `dt` [s].

    Everybody does what the storyboard says, as a perfect controller would: the material of a lane, which is of the road
    and not of the storyboard, limits nobody here.
    Raises ScenarioError if the scenario holds an element that cannot run.
    """
    board = Storyboard(scenario, network, seed=seed, reading=reading, lane_friction=False)
    board.start()
    board.settle()
    watch = Plausibility(board)
    rows: list[Row] = []

    def record(time: float) -> None:
        for entity in board.entities.values():
            if entity.active:
                rows.append(Row(time, entity.name, entity.x, entity.y, turned(entity.h), entity.speed))

    record(0.0)
    steps = round(duration / dt)
    due = 1
    for _ in range(steps):
        board.step(dt)
        watch.look(dt)
        if board.done:
            break
        # the step that comes nearest to a multiple of 0.05 s, whatever dt is
        if board.time >= due * ROW_STEP - 0.5 * dt + 1e-9 or dt > ROW_STEP:
            record(round(due * ROW_STEP, 9) if dt <= ROW_STEP else board.time)
            due = math.floor(board.time / ROW_STEP + 0.5) + 1
    implausible = watch.findings()
    told = tuple(Finding(CODE, "warning", str(scenario.path), None, "", text=said_of(each)) for each in implausible)
    findings = (*board.report(), *told)
    return Played(rows, board.transitions, findings, board.done, board.time, board.world.monitors, implausible)


def turned(angle: float) -> float:
    """The angle [rad] in [0, 2 pi)."""
    turn = angle % (2.0 * math.pi)
    return 0.0 if turn >= 2.0 * math.pi else turn
