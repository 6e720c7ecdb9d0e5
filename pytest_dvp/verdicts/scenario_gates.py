"""A gate file against the scenario beside it: whether there is one, whether the task lies on its road, whether the
events and entities are of the scenario; and against the files beside it that it names."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from pathlib import Path

from openscenario.findings import Finding, ScenarioError, listed, natural, nearest
from openscenario.model.scenario import Scenario
from openscenario.read import read_cases, read_scenario
from openscenario.read.road import RoadFacts, road_facts
from openscenario.xml import read_xml
from pytest_dvp.verdicts.gate import GateError, GateFile
from pytest_dvp.verdicts.gate_file import read_gates
from pytest_dvp.verdicts.gate_file_lines import Lines, locate_lines
from pytest_dvp.verdicts.gate_references import unknown_names
from vehicle.messages import RoadPoint

ENDING = ".gates.toml"
NEED_A_GOAL = ("goal_reached", "completion_time")
_ROUTES = ("AssignRouteAction", "AcquirePositionAction")


def check_beside(path: Path, *, library: Sequence[Path] = (), rootdir: Path | None = None) -> tuple[Finding, ...]:
    """Findings of a gate file that only its scenario shows; none where either of them is wrong in itself."""
    if not path.name.endswith(ENDING):
        return tuple(_wrong_name(path))
    scenario_path = path.with_name(f"{path.name.removesuffix(ENDING)}.xosc")
    if not scenario_path.is_file():
        return (_orphan(path, scenario_path),)
    try:
        gates = read_gates(path)
        lines = locate_lines(path.read_text(encoding="utf-8"))
        scenario_path = _driven(scenario_path, library, rootdir)
        scenario = read_scenario(scenario_path, library=library, rootdir=rootdir)
        road = scenario.road_network.logic_file
        facts = None if road is None else road_facts(road)
    except (GateError, ScenarioError):
        return ()  # each file's own check tells
    found = [*_places(gates, facts, lines, str(path), scenario_path.name)] if facts is not None else []
    found += unknown_names(gates, scenario, scenario_path.name)
    found += _no_traffic(gates, lines, path)
    return (*found, *_without_goal(gates, scenario, facts, str(path), scenario_path.name))


def gates_of(path: Path, *, library: Sequence[Path] = (), rootdir: Path | None = None) -> Path | None:
    """The gate file that a run of this scenario takes by itself; of a distribution without one that of its scenario."""
    try:
        named = dict.fromkeys((path, _driven(path, library, rootdir)))
    except ScenarioError:
        named = {path: None}  # its own check tells
    beside = (one.with_name(f"{one.stem}{ENDING}") for one in named)
    return next((file for file in beside if file.is_file()), None)


def _driven(path: Path, library: Sequence[Path], rootdir: Path | None) -> Path:
    """The scenario that a run of the file drives: of a distribution the one that it varies."""
    if read_xml(path).root.find("ParameterValueDistribution") is None:
        return path
    return read_cases(path, library=library, rootdir=rootdir).scenario or path


def _wrong_name(path: Path) -> Iterator[Finding]:
    stem = next((path.name[: -len(end)] for end in (".gate.toml", "_gates.toml") if path.name.endswith(end)), "")
    if not stem:
        return
    right = path.with_name(stem + ENDING)
    # Beside a scenario without a gate file it is meant to be that file, and a run would silently not use it.
    lost = path.with_name(f"{stem}.xosc").is_file() and not right.is_file()
    yield Finding(
        "dvp.gates.name",
        "error" if lost else "warning",
        str(path),
        None,
        "",
        text="a run does not find a gate file of this name",
        found=path.name,
        allowed=f"NAME{ENDING} beside NAME.xosc, or any file with --gates",
        hint=f"did you mean {right.name}?",
    )


def _orphan(path: Path, scenario: Path) -> Finding:
    names = sorted(other.name for other in path.parent.glob("*.xosc"))
    return Finding(
        "dvp.gates.orphan",
        "warning",
        str(path),
        None,
        "",
        text=f"no scenario {scenario.name} beside this gate file: no run finds it by itself",
        allowed=listed(names),
        hint=nearest(scenario.name, names),
    )


def _places(gates: GateFile, facts: RoadFacts, lines: Lines, file: str, scenario: str) -> Iterator[Finding]:
    if gates.task is None:
        return
    for key, place in (("start", gates.task.start), ("goal", gates.task.goal)):
        if place is None:
            continue
        line = lines.task.get(key, lines.top.get("task"))
        wrong = _off_road(place, facts)
        if wrong is not None:
            part, text, found, allowed, hint = wrong
            yield Finding(
                "dvp.task",
                "error",
                file,
                line,
                f"task.{key}.{part}",
                text=f"{text} in {scenario}",
                found=found,
                allowed=allowed,
                hint=hint,
            )


def _off_road(place: RoadPoint, facts: RoadFacts) -> tuple[str, str, str, str, str] | None:
    """(key, text, found, allowed, hint) if the place does not exist."""
    length = facts.lengths.get(place.road)
    if length is None:
        roads = sorted(facts.lengths, key=natural)
        hint = "" if place.road.isdigit() else nearest(place.road, roads)  # 2 is no likely 29
        return "road", f"no road {place.road[:40]}", "", listed(roads), hint
    if place.s > length:
        allowed = f"0 ... {length:g} m on road {place.road}"
        return "s", "beyond the end of the road", f"{place.s:g}", allowed, ""
    here = [numbers for start, numbers in facts.lanes[place.road] if start <= place.s]
    lanes = sorted((here[-1] if here else frozenset[int]()) - {0})
    if place.lane not in lanes:
        text = f"no lane {place.lane} on road {place.road} at s = {place.s:g} m"
        return "lane", text, "", ", ".join(map(str, lanes)) or "none", ""
    return None


def _no_traffic(gates: GateFile, lines: Lines, path: Path) -> Iterator[Finding]:
    """The files of the background traffic that are not there."""
    named = dataclasses.asdict(gates.traffic) if gates.traffic is not None else {}
    for key, name in named.items():
        if not (path.parent / name).is_file():
            ending = name.partition(".")[2]  # net.xml of urban.net.xml
            there = [file.name for file in path.parent.iterdir() if file.name.endswith(ending)]
            yield Finding(
                "dvp.gates.traffic",
                "error",
                str(path),
                lines.top.get("traffic"),
                f"traffic.{key}",
                text="no such file beside this one",
                found=name,
                allowed=listed(sorted(there)),
                hint=nearest(name, there),
            )


def _without_goal(
    gates: GateFile, scenario: Scenario, facts: RoadFacts | None, file: str, name: str
) -> Iterator[Finding]:
    if (gates.task is not None and gates.task.goal is not None) or _has_route(scenario):
        return
    for number, gate in enumerate(gates.gates, start=1):
        if gate.metric in NEED_A_GOAL:
            yield Finding(
                "dvp.gates.no_goal",
                "warning",
                file,
                gate.line,
                f"gate[{number}].metric",
                text=f"{gate.metric} needs a goal, and neither this file nor the Init of {name} names one",
                allowed=f"[task] goal = {_a_place(facts)}",
                hint="without a goal the verdict is INCONCLUSIVE",
            )


def _a_place(facts: RoadFacts | None) -> str:
    """A place that exists, as a gate file writes it: the middle of the longest road."""
    if facts is None or not facts.lengths:
        return '{ road = "1", lane = -1, s = 420.0 }'
    road = max(facts.lengths, key=lambda name: facts.lengths[name])
    s = round(0.5 * facts.lengths[road], 1)
    here = [numbers for start, numbers in facts.lanes[road] if start <= s]
    lanes = [number for number in (here[-1] if here else ()) if number]
    lane = min(lanes, key=lambda number: (abs(number), number), default=-1)
    return f'{{ road = "{road}", lane = {lane}, s = {s} }}'


def _has_route(scenario: Scenario) -> bool:
    return any(
        type(action).__name__ in _ROUTES
        for private in scenario.storyboard.init.actions.privates
        for action in private.private_actions
    )
