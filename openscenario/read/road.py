"""The road file that a scenario names: where it lies, and whether roads, lanes and signals of the scenario exist on it.

Only lengths, lane numbers and signal ids are looked at, which takes about as long as reading the XML; the geometry is
for `openscenario.road` to read.
"""

from __future__ import annotations

import dataclasses
import functools
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from openscenario.commonroad.roads import opendrive
from openscenario.commonroad.source import ROOT as COMMONROAD
from openscenario.commonroad.source import read
from openscenario.findings import ScenarioError, listed, natural, nearest
from openscenario.model.actions import AbsoluteTargetLane, TeleportAction
from openscenario.model.positions import LanePosition, Position, RelativeLanePosition, RoadPosition
from openscenario.model.scenario import RoadNetwork
from openscenario.model.storyboard import Init
from openscenario.paths import PathError, Roots
from openscenario.read.context import Context
from openscenario.road.single_sides import complete_sides
from openscenario.xml import Node, decoded, parse_xml, read_bytes

_TOLERANCE: Final = 0.01  # m; lengths in files are rounded
_HEAD_BYTES: Final = 1 << 16
_ROOT: Final = re.compile(r"\s*<([\w.:-]+)")
_DOCTYPE: Final = "<!DOCTYPE"
_ASIDE: Final = re.compile(r"<\?.*?\?>|<!--.*?-->", re.DOTALL)  # what may stand before the root
_SHARED_BYTES: Final = 1 << 20  # facts of larger files are not kept


@dataclass(frozen=True, slots=True)
class RoadFacts:
    """Length [m] and lanes (start of the section [m], lane numbers) by road id; ids and names of signals."""

    lengths: Mapping[str, float]
    lanes: Mapping[str, tuple[tuple[float, frozenset[int]], ...]]
    signals: frozenset[str]
    open_ends: frozenset[tuple[str, bool]]  # road ids, and whether it is the end: where no link leads further


def with_road(network: RoadNetwork | None, roots: Roots, context: Context) -> RoadNetwork | None:
    """The road network with the resolved path of its logic file, which must lie in the allowed folders."""
    if network is None or network.logic is None:
        return network
    logic = network.logic
    if not logic.filepath.strip():  # a name that leads to no file: as if the element were not there
        return dataclasses.replace(network, logic=None)
    try:
        path = roots.find_road(logic.filepath)
    except PathError as error:
        context.error(
            error.code, logic.at, "@filepath", error.text, found=logic.filepath, allowed=error.allowed, hint=error.hint
        )
        return None
    if not _as_written(logic.filepath, roots, path):
        context.warning(
            "path.found_elsewhere",
            logic.at,
            "@filepath",
            "there is no such file here; another one of this name is used",
            found=logic.filepath,
            hint=f"used: {path}",
        )
    return dataclasses.replace(network, logic=dataclasses.replace(logic, path=path))


def _as_written(written: str, roots: Roots, path: Path) -> bool:
    try:
        return roots.inside(written, roots.base) == path
    except PathError:
        return False


def check_on_road(network: RoadNetwork | None, context: Context) -> None:
    """Notes positions beyond a road or lane that exists, and signals that nothing shows."""
    path = None if network is None else network.logic_file
    if network is None or path is None or _is_no_road(network, path, context) or not context.on_road:
        return
    try:
        facts = road_facts(path)
    except ScenarioError as error:
        context.findings.found.extend(error.findings)
        return
    if facts is None:
        return
    phases = [phase for controller in network.traffic_signals for phase in controller.phases]
    signals = facts.signals | {state.traffic_signal_id for phase in phases for state in phase.traffic_signal_states}
    for element in context.on_road:
        if isinstance(element, LanePosition | RoadPosition):
            _check_position(element, facts, context)
        elif isinstance(element, AbsoluteTargetLane):
            _check_lane(element, facts, context)
        elif element.name not in signals:
            context.error(
                "reference_control.resolvable_signal_id_in_traffic_signal_state_action",
                element.at,
                "@name",
                "the road has no such signal",
                found=element.name,
                allowed=listed(sorted(signals, key=natural)) or "none",
            )


def _is_no_road(network: RoadNetwork, path: Path, context: Context) -> bool:
    """True, and noted once at the LogicFile, if the file it names is of another kind: no road of it could be found."""
    try:
        with path.open("rb") as file:
            head = _ASIDE.sub("", decoded(file.read(_HEAD_BYTES)))
    except OSError:
        return False  # reading the road reports it
    if head.lstrip()[: len(_DOCTYPE)].upper() == _DOCTYPE:
        return False  # reading the road refuses it by its name
    root = _ROOT.match(head)
    name = root[1] if root else ""
    if network.logic is None or name.rpartition(":")[2] in ("OpenDRIVE", COMMONROAD) or (not root and not head.strip()):
        return False
    context.error(
        "asam.net:xodr:1.0.0:xml.root_tag_is_opendrive",
        network.logic.at,
        "@filepath",
        f"the file is no OpenDRIVE road network: {path}",
        found=f"<{name}>" if root else "no XML",
        allowed="<OpenDRIVE>",
        hint="name the .xodr file of the road here; other formats: convert them, for example with SUMO's netconvert",
    )
    return True


def road_facts(path: Path) -> RoadFacts | None:
    """The facts of an OpenDRIVE file, or None if its numbers are wrong: reading the road reports them.

    Raises:
        ScenarioError: no XML.
    """
    data = read_bytes(path, str(path))
    read: Callable[[bytes, str], RoadFacts | None] = _kept_facts if len(data) <= _SHARED_BYTES else _facts
    return read(data, str(path))


def _facts(data: bytes, file: str) -> RoadFacts | None:
    root = parse_xml(data, file).root
    if root.tag == COMMONROAD:
        root = opendrive(read(root, file))
    roads = root.findall("road")
    signals = {
        signal.get(key)
        for road in roads
        for group in road.findall("signals")
        for signal in group.children
        for key in ("id", "name")
    }
    signals |= {controller.get(key) for controller in root.findall("controller") for key in ("id", "name")}
    try:
        lengths = {road.get("id"): float(road.get("length")) for road in roads}
        lanes = {road.get("id"): tuple(_sections(road)) for road in roads}
    except ValueError:
        return None
    return RoadFacts(lengths, lanes, frozenset(signals - {""}), frozenset(_open_ends(roads)))


_kept_facts = functools.lru_cache(maxsize=8)(_facts)


def _open_ends(roads: list[Node]) -> Iterator[tuple[str, bool]]:
    for road in roads:
        link = road.find("link")
        for at_end, tag in ((False, "predecessor"), (True, "successor")):
            if link is None or link.find(tag) is None:
                yield road.get("id"), at_end


def _sections(road: Node) -> Iterator[tuple[float, frozenset[int]]]:
    layers = road.findall("lanes")
    for lanes in [each for each in layers if each.get("layer") != "temporary"] or layers:
        complete_sides(lanes)
        for section in lanes.findall("laneSection"):
            numbers = {int(lane.get("id")) for side in section.children for lane in side.findall("lane")}
            yield float(section.get("s")), frozenset(numbers)


def check_beside(init: Init, network: RoadNetwork | None, context: Context) -> None:
    """Notes entities put beside themselves, and beside one where the road has no such lane or no such s."""
    path = None if network is None else network.logic_file
    try:
        facts = None if path is None or context.findings.errors else road_facts(path)
    except ScenarioError:
        return  # reading the road reports it
    placed = {
        private.entity_ref: action.position
        for private in init.actions.privates
        for action in reversed(private.private_actions)  # the first one holds: a later one may start from it
        if isinstance(action, TeleportAction)
    }
    for name, position in placed.items():
        _check_circle(name, placed, context)
        if facts is not None and isinstance(position, RelativeLanePosition):
            base = placed.get(position.entity_ref)
            if isinstance(base, LanePosition):
                _check_beside(position, base, facts, context)


def _check_circle(name: str, placed: Mapping[str, Position], context: Context) -> None:
    position, others = placed[name], [name]
    while True:
        other = str(getattr(placed[others[-1]], "entity_ref", ""))
        if other == name:
            text = "an entity is put relative to where it is put"
            found = " - ".join((*others, other))
            context.error("ref.circle", position.at, "@entityRef", text, found=found)
        if other in others or other not in placed:
            return
        others.append(other)


def _check_beside(position: RelativeLanePosition, base: LanePosition, facts: RoadFacts, context: Context) -> None:
    length = facts.lengths[base.road_id]
    s = base.s + (position.ds or 0.0)
    if not 0.0 <= s <= length:
        if position.ds and (base.road_id, s > length) in facts.open_ends:
            allowed = f"{-base.s:g} to {length - base.s:g} m beside {position.entity_ref}"
            found = f"{position.ds:g}"
            context.error("road.s_out_of_range", position.at, "@ds", "beyond the road", found=found, allowed=allowed)
        return
    lane = base.lane_id + position.d_lane
    if base.lane_id * lane <= 0 and position.d_lane:  # there is no lane 0 to drive on
        lane += 1 if position.d_lane > 0 else -1
    lanes = [numbers for start, numbers in facts.lanes[base.road_id] if start <= s + _TOLERANCE][-1]
    if position.ds_lane is None and lane not in lanes:
        context.error(
            "ref.unknown_lane",
            position.at,
            "@dLane",
            f"road {base.road_id[:40]} has no lane {lane} at s = {s:g} m",
            found=str(position.d_lane),
            allowed="lanes " + ", ".join(str(number) for number in sorted(lanes)),
        )


def check_phases(network: RoadNetwork | None, context: Context) -> None:
    """Notes phases that the signal controller named with them does not have."""
    phases = {
        controller.name: [phase.name for phase in controller.phases]
        for controller in (() if network is None else network.traffic_signals)
    }
    for element in context.of_phases:
        known = phases.get(element.traffic_signal_controller_ref)
        if known is not None and element.phase not in known:
            context.error(
                "ref.unknown_phase",
                element.at,
                "@phase",
                "the signal controller has no such phase",
                found=element.phase,
                allowed=listed(known) or "none",
                hint=nearest(element.phase, known),
            )


def _check_lane(target: AbsoluteTargetLane, facts: RoadFacts, context: Context) -> None:
    """A lane that no road has anywhere is nobody's target."""
    known = {lane for sections in facts.lanes.values() for _, lanes in sections for lane in lanes}
    if target.value not in known:
        context.error(
            "ref.unknown_lane",
            target.at,
            "@value",
            "no road has such a lane",
            found=str(target.value),
            allowed=", ".join(str(number) for number in sorted(known)),
        )


def _check_position(position: LanePosition | RoadPosition, facts: RoadFacts, context: Context) -> None:
    length = facts.lengths.get(position.road_id)
    if length is None:
        context.error(
            "ref.unknown_road",
            position.at,
            "@roadId",
            "no such road",
            found=position.road_id,
            allowed=listed(sorted(facts.lengths, key=natural)),
            hint=nearest(position.road_id, facts.lengths),
        )
    elif position.s > length + _TOLERANCE:
        # nothing can be put there; as a place to drive to, the end of the road stands for it
        note = context.error if position.at in context.starts else context.warning
        note(
            "road.s_out_of_range",
            position.at,
            "@s",
            "beyond the end of the road",
            found=f"{position.s:g}",
            allowed=f"0 ... {length:g} m on road {position.road_id[:40]}",
        )
    elif isinstance(position, LanePosition):
        here = [numbers for start, numbers in facts.lanes[position.road_id] if start <= position.s + _TOLERANCE]
        lanes = here[-1] if here else frozenset[int]()
        if position.lane_id not in lanes:
            context.error(
                "ref.unknown_lane",
                position.at,
                "@laneId",
                f"road {position.road_id[:40]} has no such lane at s = {position.s:g} m",
                found=str(position.lane_id),
                allowed=", ".join(str(number) for number in sorted(lanes)) or "none",
            )
