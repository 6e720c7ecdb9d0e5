"""Board: what actions, conditions and positions may use of the storyboard that runs them.

`engine.Storyboard` is the only one. It stands apart from its uses, so that no file needs the engine for its types.
"""

from __future__ import annotations

import random
from typing import Any, Protocol

from openscenario import model
from openscenario.road.network import RoadNetwork
from openscenario.storyboard.crowd import Crowd
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.ground import Ground
from openscenario.storyboard.nodes import Node, Transition
from openscenario.storyboard.reading import Reading
from openscenario.storyboard.road_watch import RoadWatch
from openscenario.storyboard.signals import Program
from openscenario.storyboard.values import Values
from openscenario.storyboard.world import World


class Board(Protocol):
    """A scenario under way.

    time, dt    seconds of the scenario, and of the step that is being made [s]
    steps       steps made so far
    running     Init is over
    done        the stop trigger fired, or all stories have ended
    """

    scenario: model.Scenario
    network: RoadNetwork | None
    reading: Reading
    ground: Ground
    road_watch: RoadWatch
    random: random.Random
    time: float
    dt: float
    steps: int
    running: bool
    done: bool
    entities: dict[str, Entity]
    selections: dict[str, tuple[str, ...]]
    parameters: Values
    variables: Values
    world: World
    programs: dict[str, Program]
    transitions: list[Transition]
    root: Node

    def velocity(self, entity: Entity) -> tuple[float, float]:
        """vx, vy [m/s] of the motion seen last."""

    def crowd(self) -> Crowd:
        """The traffic that comes and goes."""

    def warn(self, element: model.Element, code: str, text: str) -> None:
        """Report that something went otherwise than the scenario wants."""

    def request(self, entity: Entity, kind: str, values: dict[str, Any]) -> None:
        """Ask whoever moves an external entity for something."""
