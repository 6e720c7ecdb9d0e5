"""Rules: what a road network must keep beyond its schema, each with the ASAM rule UID where one exists."""

from __future__ import annotations

from openscenario.road.attributes import Attributes
from openscenario.road.elements import OpenDrive
from openscenario.xml import Node


def check_network(attributes: Attributes, network: OpenDrive, roads: list[Node], junctions: list[Node]) -> None:
    """Add a finding for each broken rule; roads and junctions are the nodes they were read from."""
