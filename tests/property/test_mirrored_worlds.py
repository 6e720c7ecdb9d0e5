"""A story does not change with how its roads are counted: s the other way on all of them or on one, one road cut in
two, or the whole world seen in a mirror, where traffic keeps to the left.

Random stories of three vehicles on a line and an arc are told in each world, in its numbers; the places in the world
must be the same. Nothing but this symmetry is assumed: no value is known beforehand.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from pathlib import Path

import pytest

from openscenario.read import read_scenario
from openscenario.road.network import RoadNetwork, load_network
from openscenario.storyboard.engine import Storyboard
from tests.unit.storyboard.conftest import CAR, LANE, XOSC, by_entity, condition, event, group, speed, story, teleport

LENGTH, ARC, BEND, CUT = 200.0, 150.0, 1.0 / 120.0, 90.0  # m, m, 1/m, m
NAMES = ("A", "B", "C")
SECONDS = 6.0
SAME, OTHER = 1, -1
SEEDS = (9, 12, 20, 30, 34)  # stories that once differed; any others will do as well


def road(number: int, pose: tuple[float, float, float], shape: str, length: float, **ends: tuple[int, str, int]) -> str:
    """`ends`: predecessor and successor as (road, contact point, whether lanes keep their sign)."""
    links = "".join(
        f'<{end} elementType="road" elementId="{to}" contactPoint="{at}"/>' for end, (to, at, _) in ends.items()
    )
    sides = {}
    for side, ids in (("left", (2, 1)), ("right", (-1, -2))):
        of = {i: "".join(f'<{end} id="{i * sign}"/>' for end, (_, _, sign) in ends.items()) for i in ids}
        sides[side] = "".join(LANE.format(id=i).replace("<link/>", f"<link>{of[i]}</link>") for i in ids)
    x, y, h = pose
    return (
        f'<road length="{length}" id="{number}" junction="-1" rule="RHT"><link>{links}</link><planView><geometry s="0" '
        f'x="{x}" y="{y}" hdg="{h}" length="{length}">{shape}</geometry></planView><lanes><laneSection s="0">'
        f'<left>{sides["left"]}</left><center><lane id="0" type="none"/></center><right>{sides["right"]}</right>'
        "</laneSection></lanes></road>"
    )


TURN = BEND * ARC
FAR = (LENGTH + math.sin(TURN) / BEND, (1.0 - math.cos(TURN)) / BEND, TURN + math.pi)  # the arc's end, looking back
BACK = (LENGTH, 0.0, math.pi)
LINE, LEFT, RIGHT = "<line/>", f'<arc curvature="{BEND}"/>', f'<arc curvature="{-BEND}"/>'
ROADS = {
    "plain": road(1, (0, 0, 0), LINE, LENGTH, successor=(2, "start", SAME))
    + road(2, (LENGTH, 0, 0), LEFT, ARC, predecessor=(1, "end", SAME)),
    "all turned": road(1, BACK, LINE, LENGTH, predecessor=(2, "end", SAME))
    + road(2, FAR, RIGHT, ARC, successor=(1, "start", SAME)),
    "one turned": road(1, (0, 0, 0), LINE, LENGTH, successor=(2, "end", OTHER))
    + road(2, FAR, RIGHT, ARC, successor=(1, "end", OTHER)),
    "cut": road(1, (0, 0, 0), LINE, CUT, successor=(3, "end", OTHER))
    + road(3, BACK, LINE, LENGTH - CUT, predecessor=(2, "start", OTHER), successor=(1, "end", OTHER))
    + road(2, (LENGTH, 0, 0), LEFT, ARC, predecessor=(3, "start", OTHER)),
}
ROADS["mirror"] = (
    road(1, (0, 0, 0), LINE, LENGTH, successor=(2, "start", SAME))
    + road(2, (LENGTH, 0, 0), RIGHT, ARC, predecessor=(1, "end", SAME))
).replace("RHT", "LHT")
TURNED = {"all turned": (1, 2), "one turned": (2,)}


class World:
    """The numbers of one world for what the plain one calls road, lane, s, and left (`left` -1: right)."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.left = -1 if name == "mirror" else 1

    def place(self, number: int, lane: int, s: float, offset: float = 0.0) -> str:
        sign = self.left
        if self.name == "cut" and number == 1 and s > CUT:
            number, s, sign = 3, LENGTH - s, -1
        elif number in TURNED.get(self.name, ()):
            s, sign = (LENGTH if number == 1 else ARC) - s, -1
        return f'<LanePosition roadId="{number}" laneId="{sign * lane}" s="{s}" offset="{sign * offset}"/>'

    def side(self, which: str) -> str:
        left, right = ("left", "right") if self.left > 0 else ("right", "left")
        return {"left": f"{left}ToReferencedEntity", "right": f"{right}ToReferencedEntity"}.get(which, which)


def lateral(inner: str) -> str:
    return f"<PrivateAction><LateralAction>{inner}</LateralAction></PrivateAction>"


def an_action(draw: random.Random, world: World, me: str, other: str) -> str:
    kind, shape = draw.randrange(7), draw.choice(("linear", "cubic", "sinusoidal"))
    value, step = draw.uniform(1.0, 4.0), world.left * draw.choice((-1, 1))
    aside, along = world.left * draw.uniform(-1.2, 1.2), draw.uniform(-15.0, 15.0)
    yes, system = draw.choice(("true", "false")), draw.choice(("road", "entity"))
    if kind == 0:
        return lateral(
            f'<LaneChangeAction><LaneChangeActionDynamics dynamicsShape="{shape}" value="{value}" dynamicsDimension='
            f'"time"/><LaneChangeTarget><RelativeTargetLane entityRef="{me}" value="{step}"/></LaneChangeTarget>'
            "</LaneChangeAction>"
        )
    if kind == 1:
        return lateral(
            f'<LaneOffsetAction continuous="{yes}"><LaneOffsetActionDynamics dynamicsShape="{shape}" maxLateralAcc='
            f'"{value}"/><LaneOffsetTarget><RelativeTargetLaneOffset entityRef="{other}" value="{aside}"/>'
            "</LaneOffsetTarget></LaneOffsetAction>"
        )
    if kind == 2:
        side = world.side(draw.choice(("left", "right", "any")))
        return lateral(
            f'<LateralDistanceAction entityRef="{other}" distance="{value}" continuous="{yes}" freespace="{yes}" '
            f'coordinateSystem="road" displacement="{side}"><DynamicConstraints maxAcceleration="{value}" '
            'maxDeceleration="2"/></LateralDistanceAction>'
        )
    if kind == 3:
        return (
            f'<PrivateAction><LongitudinalAction><LongitudinalDistanceAction entityRef="{other}" continuous="true" '
            f'distance="{5 * value}" freespace="{yes}" coordinateSystem="{system}" displacement="any">'
            f'<DynamicConstraints maxAcceleration="{value}" maxDeceleration="4" maxSpeed="20"/>'
            "</LongitudinalDistanceAction></LongitudinalAction></PrivateAction>"
        )
    if kind == 4:
        return teleport(f'<RelativeLanePosition entityRef="{other}" dLane="0" dsLane="{along}" offset="{aside}"/>')
    if kind == 5:
        return teleport(f'<RelativeObjectPosition entityRef="{other}" dx="{along}" dy="{aside}"/>')
    return speed(3.0 * value, shape, "time", value)


def a_condition(draw: random.Random, world: World, me: str, other: str) -> str:
    kind, rule = draw.randrange(6), draw.choice(("greaterThan", "lessThan"))
    free, system = draw.choice(("true", "false")), draw.choice(("road", "entity"))
    way = draw.choice(("longitudinal", "lateral", "euclidianDistance"))
    how = f'rule="{rule}" freespace="{free}" coordinateSystem="{system}" relativeDistanceType="{way}"'
    value, where = draw.uniform(0.5, 5.0), (draw.choice((1, 2)), draw.choice((-2, -1, 1, 2)), draw.uniform(20.0, 140.0))
    if kind == 0:
        return f'<ByValueCondition><SimulationTimeCondition value="{value}" rule="greaterThan"/></ByValueCondition>'
    tests = (
        f'<RelativeDistanceCondition entityRef="{other}" value="{6 * value}" {how}/>',
        f'<TimeHeadwayCondition entityRef="{other}" value="{value}" {how}/>',
        f'<TimeToCollisionCondition value="{2 * value}" {how}><TimeToCollisionConditionTarget><EntityRef entityRef='
        f'"{other}"/></TimeToCollisionConditionTarget></TimeToCollisionCondition>',
        f'<DistanceCondition value="{8 * value}" {how}><Position>{world.place(*where)}</Position></DistanceCondition>',
        '<RelativeClearanceCondition freeSpace="true" oppositeLanes="true" distanceForward="30" distanceBackward="10">'
        f'<RelativeLaneRange from="{-1 if world.left > 0 else 0}" to="{0 if world.left > 0 else 1}"/>'
        "</RelativeClearanceCondition>",
    )
    return by_entity(tests[kind - 1], me)


def told(seed: int, world: World) -> str:
    """The story of a seed in the numbers of a world."""
    draw = random.Random(seed)
    init, stories = "", ""
    for name in NAMES:
        number, lane = draw.choice((1, 1, 2)), draw.choice((-2, -1, 1, 2))
        where = world.place(number, lane, draw.uniform(30.0, 110.0), draw.uniform(-1.0, 1.0))
        init += f'<Private entityRef="{name}">{teleport(where)}{speed(draw.uniform(4.0, 14.0))}</Private>'
    for name in NAMES:
        events = ""
        for number in range(2):
            other = draw.choice([each for each in NAMES if each != name])
            act, start = an_action(draw, world, name, other), a_condition(draw, world, name, other)
            events += event(f"{name}{number}", act, start=group(condition(start)), priority="override")
        stories += story(events, actor=name, name=f"story {name}")
    entities = "".join(
        f'<ScenarioObject name="{n}">{CAR.format(name=n, acceleration=10)}</ScenarioObject>' for n in NAMES
    )
    text = XOSC.format(entities=entities, init=init, stories=stories, stop="")
    return text.replace("straight.xodr", f"{world.name}.xodr")


Play = Callable[[int, str], list[tuple[float, ...]]]


@pytest.fixture(scope="module")
def play(tmp_path_factory: pytest.TempPathFactory) -> Play:
    """play(seed, world) -> x, y, heading, speed of all at every tenth of a second, as the plain world has them."""
    folder: Path = tmp_path_factory.mktemp("worlds")
    networks: dict[str, RoadNetwork] = {}
    for name, roads in ROADS.items():
        (folder / f"{name}.xodr").write_text(
            f'<?xml version="1.0"?><OpenDRIVE><header revMajor="1" revMinor="6" name=""/>{roads}</OpenDRIVE>'
        )
        networks[name] = load_network(folder / f"{name}.xodr")

    def run(seed: int, name: str) -> list[tuple[float, ...]]:
        world, file = World(name), folder / "story.xosc"
        file.write_text(told(seed, world))
        board = Storyboard(read_scenario(file), networks[name])
        board.start()
        seen: list[tuple[float, ...]] = []
        for step in range(round(SECONDS / 0.01)):
            board.step(0.01)
            if step % 10 == 0:
                for each in board.entities.values():
                    seen.append((each.x, world.left * each.y, world.left * each.h, each.speed))
        return seen

    return run


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.nightly(by_day=5)
def test_a_story_is_the_same_in_all_worlds(play: Play, seed: int) -> None:
    plain = play(seed, "plain")
    for name in ROADS:
        for here, there in zip(plain, play(seed, name), strict=True):
            assert math.dist(here[:2], there[:2]) < 0.01, name
            assert abs(math.remainder(here[2] - there[2], math.tau)) < 0.01, name
            assert abs(here[3] - there[3]) < 0.01, name
