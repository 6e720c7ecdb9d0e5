"""Drivers for others: what moves a vehicle of whose controller a file says that it reacts to traffic.

The standard leaves controllers to the tools. A controller whose name, or a property of which, asks for one that reacts
(`ACCController`, `InteractiveController`, `npc_vehicle_control`, ...) drives with adaptive cruise control by the
intelligent driver model (`car_following`), and keeps its lane, back to the middle of it. Any other controller is the
default one, which keeps speed and lane. The vehicle under test has none of them: its stack drives it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from openscenario.interactive import is_interactive
from openscenario.model.entities import ObjectController, ego_among
from openscenario.storyboard.car_following import HEADWAY, ahead, following, queues
from openscenario.storyboard.driver import Driver
from openscenario.storyboard.motion import lean

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board
    from openscenario.storyboard.entity import Entity

BACK: Final = 2.0  # s, time constant with which lane keeping goes back to the middle of the lane; chosen
ASIDE: Final = 1.0  # m/s, as fast as it goes there; chosen


def assign(entity: Entity, controllers: Sequence[ObjectController], board: Board) -> None:
    """Give an entity a controller; of several the first that reacts to traffic. It is not at work yet."""
    found = next((each.controller for each in controllers if is_interactive(each.controller)), None)
    if found is None or entity.external or entity.kind != "vehicle" or entity.name == ego_among(board.entities):
        entity.driver = None
    else:
        entity.driver = Driver(found)


def activate(entity: Entity, *, longitudinal: bool | None, lateral: bool | None) -> None:
    """Let the controller of an entity begin or end its work in a domain; None leaves it as it is."""
    driver = entity.driver
    if driver is None:
        return
    if longitudinal is not None:
        driver.longitudinal = longitudinal
        if longitudinal and driver.wished is None:
            driver.wished = entity.speed if entity.set_speed is None else entity.set_speed
    if lateral is not None:
        driver.lateral = lateral


def drive(board: Board, dt: float) -> None:
    """New speeds and offsets of all that such a driver drives, where no action holds the domain, for `dt` [s]."""
    ground = board.ground
    at_work = [each for each in board.entities.values() if each.driver is not None and each.driver.at_work]
    if not at_work or ground.network is None:
        return
    lanes = queues(board.entities.values(), ground)
    for entity in at_work:
        driver = entity.driver
        if driver is None or entity.moved or not entity.active or entity.drawn_by is not None:
            continue
        ground.track(entity)
        if driver.longitudinal and entity.longitudinal is None:
            gap, other = ahead(entity, lanes, ground)
            wished = min(entity.speed if driver.wished is None else driver.wished, entity.max_speed)
            wanted = following(entity.speed, wished, gap, other, driver.headway or HEADWAY)
            wanted = min(max(wanted, -entity.max_deceleration), entity.max_acceleration)
            entity.speed = max(0.0, entity.speed + wanted * dt)
        if driver.lateral and entity.lateral is None and entity.offset != 0.0:
            rate = min(max(-entity.offset * entity.sense / BACK, -ASIDE), ASIDE)
            if lean(entity, rate, dt):
                entity.offset += rate * entity.sense * dt
