"""Writes docs/openscenario.md from the model and the storyboard:  python -m scripts.make_openscenario_page

The rows are the dataclasses of the model; what runs is what the storyboard registers. A test says so when the page is
behind, or when an element has no row.
"""

from __future__ import annotations

import inspect
import typing
from collections.abc import Iterator, Mapping
from pathlib import Path

from openscenario import model
from openscenario.model.kinds import Element
from openscenario.model.positions import Shape
from openscenario.model.storyboard import AnyAction
from openscenario.plan import ElementPlan, Leaf, Table, plan_of, tag_path
from openscenario.read.header import VERSIONS
from openscenario.storyboard import positions, trajectories
from openscenario.storyboard.engine import Storyboard
from openscenario.storyboard.registry import action_factories, condition_factories
from openscenario.storyboard.unsupported import Unsupported

PAGE = Path(__file__).resolve().parents[1] / "docs" / "openscenario.md"

RUN, ACCEPTED, REFUSED = "run", "accepted", "refused"
FILES = (model.CatalogFile, model.DistributionFile, model.Scenario)  # what a file becomes; not elements of it
ACCEPTING = "openscenario.storyboard.actions.accepted"

_VERSIONS = " to ".join(f"{major}.{minor}" for major, minor in (VERSIONS[0], VERSIONS[-1]))

HEAD = f"""\
# OpenSCENARIO: what is run, accepted, refused

This page lists every element of OpenSCENARIO XML {_VERSIONS}. Other spellings of older versions (`overwrite`,
`velocity`, ...) are read as well. `python -m scripts.make_openscenario_page` writes this page.

- **run**: the element acts as the standard says.
- **accepted**: the element is read, checked and written back. It changes nothing here, or only what the row says.
- **refused**: `dvp play` and `dvp run` report an error with file and line before anything moves. A file with such an
  element never runs without it. `dvp check X.xosc` exits with 1 exactly when `dvp run X.xosc` would be refused before
  its first tick: it carries out the Init and works out the task of the ego in a process of its own.

A warning of `dvp check` (exit code 0) marks an element that runs but probably not as intended: a shape that has no time
(`value.no_transition`), or a scenario that never ends (`storyboard.never_ends`), because no stop trigger can become
true and an act can never end. The second warning is given only if it follows from the file: times before the start,
parameters that nothing sets, elements that wait for these or for each other, actions that never end by themselves.

The column "with" names elements that belong to the element of the row and are treated like it. An element that is not
on this page is not in the standard and causes an error. OpenSCENARIO DSL (`.osc`), lanelet2 and SUMO are refused by
name; CommonRoad XML is read (see below).
"""

DISTRIBUTIONS = """
## Parameter distributions

A file with a `ParameterValueDistribution` describes a set of runs of its `ScenarioFile`. This one, `speeds.xosc`,
describes five runs of `overtaking.xosc` with the parameter `oncoming_speed` at 2, 3, 4, 5 and 6:

```xml
<?xml version="1.0" encoding="UTF-8"?>
<OpenSCENARIO>
  <FileHeader revMajor="1" revMinor="2" date="2026-01-01T00:00:00" author="" description=""/>
  <ParameterValueDistribution>
    <ScenarioFile filepath="overtaking.xosc"/>
    <Deterministic>
      <DeterministicSingleParameterDistribution parameterName="oncoming_speed">
        <DistributionRange stepWidth="1"><Range lowerLimit="2" upperLimit="6"/></DistributionRange>
      </DeterministicSingleParameterDistribution>
    </Deterministic>
  </ParameterValueDistribution>
</OpenSCENARIO>
```

```
pytest speeds.xosc                    # one item for each case: speeds.xosc::dt[3-oncoming_speed=4]
pytest speeds.xosc --dvp-cases 50     # 50 random cases, the same for the same --dvp-seed
dvp run speeds.xosc --cases 50
dvp check speeds.xosc                 # number of cases; unknown parameters, values outside constraints, step 0, ...
```

More than 1000 cases run only if `--cases` gives their number. A deterministic distribution consists of every
combination of its values; the last distribution of the file changes fastest. The number of cases is computed without
building them. A range contains its upper limit if a step ends there, counted in decimals (1.1 to 1.5 by 0.2 is three
values).

A stochastic distribution draws `numberOfTestRuns` cases from its `randomSeed` (without one: from `--seed`). The draw of
a case depends only on the seed, the name of the parameter and the number of the case. `LogNormalDistribution` has the
expected value and variance of the log-normal distribution itself, not of its logarithm. Drawn values for whole
parameters are rounded to the nearest.

Each case is judged by the gate file next to the distribution (`speeds.gates.toml`), or by the one next to its
scenario. Its run folder is named after the distribution and the number of the case (`runs/0012-speeds-07-dt`). Cases
run on the digital twin only: an automatic variation never drives a real car.

In Python: `openscenario.read.read_cases(path)` gives `count`, `cases[n]` and an iterator.
"""

OPEN = """
## Where the standard leaves the meaning open

In these cases, the implementation follows the widely used tools, if they agree or if nothing contradicts them:

- `SynchronizeAction` names no speed profile. Here it uses ramps of constant acceleration, one if that fits, otherwise
  two. The pace of the master is that of its last motion; a teleport does not count as motion. At t = 0, and in the
  instant in which a trajectory takes control of the master, the master therefore stands. An entity with a final speed
  stands as well, until the last ramp fits.
- `SpeedAction`, relative to another entity and not `continuous`: the target moves with that entity until it is reached.
  Relative to the entity itself, the target is fixed at the start. With `time`, the target of that later moment is
  reached then. With `rate`, the speed changes at this rate and never faster. With `distance`, the change takes the
  whole distance. A step sets the speed at once, but only at the start. After that, as everywhere, a vehicle changes its
  speed no faster than its `Performance` permits, whichever `followingMode` is given.
- `SpeedProfileAction`: the limits are those of its `DynamicConstraints`, or of the vehicle's `Performance` where these
  state none. If the limits need more time than an entry gives, this entry and all later ones are delayed, with a
  warning. Speeds beyond `maxSpeed` are cut to it. Mode `position` uses straight lines, without a limit of jerk. In mode
  `follow`, each corner is a parabola of the allowed jerk; if there is no room for it, each entry is reached separately,
  with no acceleration there. An `entityRef` means the speed of that entity at the start. Accelerations do not jump.
- `DynamicConstraints` of the two distance actions: the narrower of these and, along the road, the `Performance` holds.
  Limits of jerk apply to stronger acceleration or braking, not to their release. Along the road, an entity comes no
  faster than it can still brake before its place. Without constraints, the entity is put at the distance at once, and
  kept there no faster than the vehicle's `maxSpeed`.
- `RelativeLanePosition` with neither `ds` nor `dsLane`, both optional since 1.1, means next to the other entity, as
  with `ds` of 0 (lanes and offset are those of the road). With both, it is refused.
- `LaneOffsetAction`, continuous and relative to another entity: `maxLateralAcc` holds on the way and afterwards; the
  follower arrives later if the other entity moves over more sharply.
- `TeleportAction`: the default controller continues from there 10 ms later, other actions at once.
- If a lane ends and its road or the linked road continues, the default controller continues in the nearest lane of the
  same side. If the road ends, it stops.
- `LightStateAction`: flashing has no regular ending, as an animation in a loop has none; an action on the same light of
  the same entity stops it. On and off end with the transition time.
- `freespace` distances to or from a vehicle with trailers are those of the nearest parts: a trailer belongs to its
  vehicle.
- `alongRoute` (deprecated): the distance along the straightened road; a lateral distance counts, as in the straight
  line that `false` means.
- NURBS with time stamps: a control point's time is that of the place of its greatest influence, or of the last whole
  metre of the control polygon before it; between, time runs evenly in the curve's parameter.
- `LateralDistanceAction` names no law. Across a road: a critically damped spring; in entity coordinates: steering for
  the line next to the other entity, with a turning radius of 1.5 v²/a, and into that entity's direction.
- Distances in the coordinates of a trajectory are defined while the measuring entity follows one; otherwise they are
  infinite.
- A closed `Route` leads the default controller from its last waypoint back to its first, round and round, and a
  `RoutePosition` may lie on that way. A stack that drives gets the waypoints once.
- Following mode `follow`: constant acceleration between the time stamps of a polyline, and even turning; `position`:
  constant speed between them, turning at the vertices. A closed polyline with time stamps comes back to its first
  vertex at the speed of the leg before.

Where the standard is explicit, the implementation follows it, whatever other tools do, except for the coordinates of
CARLA (see below) and for three rules that existing scenarios rely on. These follow esmini unless `--reading standard`
is given, with a warning where it mattered. `docs/conformance.md` quotes the clauses.
"""

FOUND = """
## Files from elsewhere

- **The road.** A `LogicFile` that leads nowhere is looked for in the folder of the scenario, in the root folder and in
  each `--library` folder: first by its path, then by its bare name, with `.xodr` if no ending is written. So `Town04`,
  as CARLA writes it, finds `Town04.xodr`. A warning (`path.found_elsewhere`) says which file is used. If there is
  none, the error lists the folders and the nearest name. [roads.md](roads.md) says what happens with faulty roads.
- **The ego** is the entity that `--ego` names, else the one called `Ego` in any case, else `hero` or `ego_vehicle`
  (names of CARLA), else the only vehicle with a controller.
- **Criteria of CARLA's scenario runner** (`criteria_RunningStopTest` and the like in a stop trigger) are no
  conditions. They are never true here, with a warning (`condition.criterion`); gates judge a drive.
- **Coordinates of CARLA.** A file whose description begins with `CARLA:` has its positions in CARLA's left-handed
  coordinates, as CARLA's scenario runner reads it: `y`, `dy`, `h` and curvatures change their sign, with a warning
  (`position.left_handed`). Lanes, `s`, `t` and offsets stay as they are.
- **CommonRoad XML** (2018b and 2020a) is taken where a scenario is: `dvp check`, `run` and `play X.xml`.
  Lanelets side by side become the lanes of one road, the bounds between them its lines; where lanelets of several roads
  meet, junctions join them. Obstacles follow their states and are there from the first to the last. The first planning
  problem is the task of an entity `Ego`: its start, its goal (lanelet or middle of a shape) and, as the end of the run,
  the last time step. Speed signs are limits. No car drives on sidewalks, crosswalks, bicycle lanes, borders,
  shoulders, parking or restricted lanelets. Traffic lights, occupancy sets, environment obstacles and further planning
  problems are read over, with a warning. Against commonroad-io, middles of lanes differ by less than 5 cm on bends of
  60 m, and states of obstacles by at most 6 mm and 6 mrad (`tests/interop/test_commonroad_io.py`).
- **Versions before 1.0** are refused. A missing `description` or `author` of the header is a warning.
- **Slips that can mean one thing only** are warnings: a word in another letter case (`Linear`, `False`); an optional
  attribute written as `""` or `None`; a missing `delay` (0), `selectTriggeringEntities` (false), `closed` (false),
  `maximumExecutionCount` of a maneuver group (1), name of a condition or environment, mass of a pedestrian or object;
  an attribute of a tool's own where things are described (vehicles, properties, environments); an empty `Private` or
  `Story`. A `Directory` may name the catalogue file, and limits (`Performance`, `DynamicConstraints`, `visualRange`)
  may be `INF`.

## Weather and the state of the road

An `EnvironmentAction` acts on the twin (stage `dt`) from the next tick on. Each change is an event `environment` in the
log, with the numbers that hold from then on. Parts that the action leaves out stay as they were.

- **Friction.** A `frictionScaleFactor` below 1 is the friction coefficient μ of the road; 1 and more mean the road for
  which the vehicle model was made. Along, all wheels together hold μ m g cos(slope), so a car that brakes hard enough
  stops from v in v²/(2 μ g). Across, each axle holds what the circle of friction leaves of μ times its load. A car
  without tyres (`kinematic_bicycle`) runs wide: its curvature is at most μ g/v². The other vehicles accelerate and
  brake with at most μ g; they keep their lanes.
- **Fog** of visual range V has the extinction ln(20)/V. **Rain** and **snow** of R mm/h add 1.076 R^0.67 and
  3.88 R^0.72 dB/km. A camera sees as far as 5 % of an object's contrast is left, at most its own reach: in fog, V. A
  LiDAR sees as far as its echo is as strong as that from its reach in clear air: R exp(extinction R) = reach.
  `vehicle/sensors/air.py` names the sources.
- **Material of a lane.** `friction` of an OpenDRIVE `material` below 1 is the coefficient of that lane from its
  `sOffset` on, for the twin and for the others; a `frictionScaleFactor` below 1 multiplies it. In `dvp play`, where
  nobody but the storyboard moves anybody, it limits nobody.
- **Wind** blows towards `direction` in the map frame. Along the car, k u |u| with the speed u through the air takes the
  place of k v |v|: k is that of the effect `aero_drag`, or 0.3 ρ A / (2 m) with A = 0.81 width height. A model without
  `aero_drag` has no drag that a tail wind could take away: it only pushes a car that is slower than it. A car with
  tyres is also pushed to the side, by 2.2 ρ A / (2 m) times air speed and crosswind. `vehicle/model/wind.py` names
  sources.
- **Light.** `Sun` states it; without one, the time of day does, by the height of the sun at the latitude of the road's
  `geoReference` (50 degrees without), with the clock as solar time. Below 3.4 lx on the road a camera sees 50 m, as far
  as low beams. Around a low sun it finds nothing where glare leaves less than 5 % of a contrast: about 7 degrees at the
  horizon, 4 with the sun at 20 degrees. Clouds take the glare away. LiDARs do not need the light.
  `vehicle/sensors/light.py` has the model and its sources.
- Rain alone does not make the road slippery: the file states both. Temperature and pressure change nothing.

The panel "Weather and road" of the report lists what held from when on.

## Who drives the others

An entity keeps speed and lane unless an action says otherwise. If its assigned `Controller` asks for one that reacts to
traffic, by its name or by a property (`esminiController`, `module`, `type`, ...) such as `ACCController`,
`InteractiveController`, `NaturalDriver` or `npc_vehicle_control`, then it works from its activation on
(`ActivateControllerAction`, or `activateLongitudinal` and `activateLateral` of an `AssignControllerAction`):

- **longitudinal**: the intelligent driver model (Treiber et al. 2000; a 1.5 m/s², b 2 m/s², s₀ 2 m, T 1.5 s or the
  property `timeGap`) behind whoever is ahead in the lane. It wishes the speed of the property `setSpeed`, else the last
  one that an action asked for.
- **lateral**: back to the middle of the lane with a time constant of 2 s, at most 1 m/s.

An action that holds the domain comes first; afterwards the controller goes on. The vehicle under test (`Ego`, `hero`,
`ego_vehicle`) has no such controller, in `dvp play` either. Controllers of other names change nothing, and a note says
so (`dvp.no_effect`).

**`OverrideControllerValueAction`** holds pedals, steering wheel and gear until an action with `active="false"`. Of the
others, full throttle is `maxAcceleration`, full brake `maxDeceleration`; `BrakeForce` needs the mass (1,500 kg if it is
not stated); the road wheels stand at 1/16 of the steering wheel. Actions on the same domain come first. Of the ego, the
held values take the place of what the stack asks for. A pressed clutch and a neutral gear take the drive away; the gear
box has no other effect, and the twin does not drive backwards.

## Motion that no entity could make

`dvp play` and `dvp run` compare each step of the other entities (all but the driven ego) with

- their `Performance`: `maxSpeed`, `maxAcceleration`, `maxDeceleration` and their rates;
- the `DynamicConstraints` of the action that moves them: along the way of a `SpeedProfileAction` or
  `LongitudinalDistanceAction`, across the lane of a `LateralDistanceAction`;
- what they did before: a jump of more than 0.5 m, a turn by more than 0.2 rad without a teleport, or 3 m/s in a step of
  an entity that has no `Performance`;
- the way they face: who was put more than 45 degrees across its lane and gets a speed slides along the lane, which is
  what the standard says of an entity without a lateral action. A pedestrian that crosses needs a trajectory.

Limits may be exceeded by 5 % and a rounding. Whoever exceeds one is a finding `dvp.implausible_motion` with entity,
time, event, and which `limit` it is. The finding stands in `findings` of `result.json` and of `dvp play --json`, and
among the notes. Usual causes are trajectories with time stamps, steps of the speed, and cars that stop where their road
ends. The first step is left out: what acts at t = 0 says how a scenario begins.
"""

TRAFFIC = Path(__file__).with_name("openscenario_traffic.md").read_text(encoding="utf-8")

MEANING: Mapping[type[Element], tuple[str, str]] = {
    model.FileHeader: (RUN, "decides the version; license and properties are kept"),
    model.ParameterDeclaration: (RUN, "with constraint groups, expressions and scopes; set from outside by `--set`"),
    model.VariableDeclaration: (RUN, ""),
    model.MonitorDeclaration: (RUN, "a flag for whoever watches; see `SetMonitorAction`"),
    model.CatalogLocations: (RUN, "entries take the place of the references to them"),
    model.CatalogReference: (RUN, "with parameter assignments"),
    model.Catalog: (RUN, "a file of its own; `dvp check` reads each entry with its default values"),
    model.RoadNetwork: (RUN, "the road is an OpenDRIVE file"),
    model.SceneGraphFile: (ACCEPTED, "kept; nothing is drawn from it"),
    model.UsedArea: (ACCEPTED, "kept; nothing is limited to it"),
    model.TrafficSignalController: (
        RUN,
        "its phases set the states of traffic lights, round and round; group states are not known",
    ),
    model.Entities: (RUN, ""),
    model.ScenarioObject: (RUN, ""),
    model.EntitySelection: (RUN, "stands for its members"),
    model.Vehicle: (RUN, "bounding box, axles and performance; the dynamics of the ego are the vehicle model's"),
    model.Pedestrian: (RUN, "bounding box"),
    model.MiscObject: (RUN, "bounding box"),
    model.ExternalObjectReference: (ACCEPTED, "an entity without a size of its own"),
    model.ObjectController: (RUN, "the stack under test drives the ego; others by what reacts to traffic, see below"),
    model.Properties: (ACCEPTED, "kept; their meaning is between the file and its tool"),
    model.Storyboard: (RUN, ""),
    model.Init: (RUN, ""),
    model.Story: (RUN, "with parameters of its own"),
    model.Act: (RUN, "start and stop trigger"),
    model.ManeuverGroup: (RUN, "actors, triggering entities, execution count"),
    model.Maneuver: (RUN, ""),
    model.Event: (RUN, "priority override (overwrite), parallel, skip; execution count"),
    model.Action: (RUN, "an empty one ends at once, with a warning"),
    model.Trigger: (RUN, "groups are alternatives, the conditions of a group all needed"),
    model.Condition: (RUN, "delay; edges none, rising, falling, risingOrFalling"),
    model.ByEntityCondition: (RUN, "any or all of the triggering entities"),
    model.TransitionDynamics: (
        RUN,
        "step, linear, cubic, sinusoidal over time, distance or rate; rate is the peak rate",
    ),
    model.DynamicConstraints: (RUN, ""),
    model.Route: (RUN, ""),
    model.Trajectory: (RUN, "with and without time stamps; see below"),
    model.Environment: (RUN, "acts by an EnvironmentAction; nothing is drawn of its DomeImage"),
    model.ParameterValueDistribution: (RUN, "see below"),
    model.UserDefinedDistribution: (REFUSED, "its meaning is known to its own tool only"),
}

SECTIONS: Mapping[str, tuple[type[Element], ...]] = {
    "Files": (
        model.FileHeader,
        model.ParameterDeclaration,
        model.VariableDeclaration,
        model.MonitorDeclaration,
        model.CatalogLocations,
        model.CatalogReference,
        model.Catalog,
        model.RoadNetwork,
        model.SceneGraphFile,
        model.UsedArea,
        model.TrafficSignalController,
        model.Properties,
    ),
    "Entities": (
        model.Entities,
        model.ScenarioObject,
        model.EntitySelection,
        model.Vehicle,
        model.Pedestrian,
        model.MiscObject,
        model.ExternalObjectReference,
        model.ObjectController,
    ),
    "Storyboard": (
        model.Storyboard,
        model.Init,
        model.Story,
        model.Act,
        model.ManeuverGroup,
        model.Maneuver,
        model.Event,
        model.Action,
        model.Trigger,
        model.Condition,
        model.ByEntityCondition,
    ),
    "Shared by actions": (
        model.TransitionDynamics,
        model.DynamicConstraints,
        model.Route,
        model.Trajectory,
        model.Environment,
    ),
}


def _leaves(union: object) -> tuple[type[Element], ...]:
    """The classes of a union, flat."""
    members = typing.get_args(union)
    return tuple(cls for member in members for cls in _leaves(member)) if members else (typing.cast("type", union),)


def actions() -> tuple[type[Element], ...]:
    """Every action of the model, by path."""
    return tuple(sorted(set(_leaves(AnyAction)), key=lambda cls: (cls.XML, cls.__name__)))


def conditions() -> tuple[type[Element], ...]:
    """Every condition of the model."""
    found = {*_leaves(model.EntityCondition), *_leaves(model.ByValueCondition)}
    return tuple(sorted(found, key=lambda cls: cls.__name__))


def shapes() -> tuple[type[Element], ...]:
    """Every shape of a trajectory."""
    return _leaves(Shape)


def places() -> tuple[type[Element], ...]:
    """Every position."""
    return tuple(sorted(_leaves(model.Position), key=lambda cls: cls.__name__))


def status(cls: type[Element]) -> tuple[str, str]:
    """What happens to an element, and what is to be said about it."""
    if cls in MEANING:
        return MEANING[cls]
    if cls in actions() or cls in conditions():
        factory = {**action_factories(), **condition_factories()}.get(cls)
        if factory is None:
            return REFUSED, ""
        return (ACCEPTED if factory.__module__ == ACCEPTING else RUN), _first_line(factory)
    if cls in places():
        return (RUN if _is_resolved(cls) else REFUSED), ""
    if cls in shapes():
        return (RUN if cls.__name__ in inspect.getsource(trajectories) else REFUSED), ""
    return RUN, ""


def _is_resolved(cls: type[Element]) -> bool:
    """Whether the storyboard takes up a kind of position; the one it is shown has no values, and none is needed."""
    try:
        positions.resolver(typing.cast("model.Position", cls.__new__(cls)), typing.cast("Storyboard", None))
    except Unsupported:
        return False
    except AttributeError:  # it was looked into
        return True
    return True


def _first_line(factory: object) -> str:
    return (inspect.getdoc(factory) or "").split("\n\n")[0].replace("\n", " ").strip()


def rows() -> dict[str, tuple[type[Element], ...]]:
    """The elements that have a row, by heading."""
    spread = tuple(
        dict.fromkeys(
            leaf.plan.cls
            for cls in (model.DeterministicSingleParameterDistribution, model.StochasticDistribution)
            for leaf in _below(plan_of(cls).children)
        )
    )
    return {
        **SECTIONS,
        "Actions": actions(),
        "Conditions": conditions(),
        "Positions": places(),
        "Trajectories": shapes(),
        "Distributions": (
            model.ParameterValueDistribution,
            model.DeterministicSingleParameterDistribution,
            model.DeterministicMultiParameterDistribution,
            model.StochasticDistribution,
            *spread,
        ),
    }


def _below(table: Table) -> Iterator[Leaf]:
    for entry in table.values():
        if isinstance(entry, Leaf):
            yield entry
        else:
            yield from _below(entry)


def parts(cls: type[Element], own: frozenset[type[Element]]) -> tuple[type[Element], ...]:
    """The elements below one that have no row of their own, in the order of the model."""
    found: dict[type[Element], None] = {}
    stack: list[ElementPlan] = [plan_of(cls)]
    while stack:
        for leaf in _below(stack.pop().children):
            inner = leaf.plan.cls
            if inner not in own and inner not in found:
                found[inner] = None
                stack.append(leaf.plan)
    return tuple(found)


def name(cls: type[Element]) -> str:
    """The element as the file spells it; one that only its parent tells apart carries the parent's tag."""
    path = tag_path(cls)
    return path[-1] if path[-1] == cls.__name__ else cls.__name__


def page() -> str:
    """The whole page."""
    table = rows()
    own = frozenset(cls for listed in table.values() for cls in listed)
    counts = {each: sum(status(cls)[0] == each for cls in own) for each in (RUN, ACCEPTED, REFUSED)}
    out = [HEAD, "Rows: " + ", ".join(f"{number} {each}" for each, number in counts.items()) + ".", ""]
    for title, listed in table.items():
        out += [f"## {title}", "", "| element | | meaning here | with |", "|---|---|---|---|"]
        for cls in listed:
            verdict, meaning = status(cls)
            below = ", ".join(name(part) for part in parts(cls, own))
            out.append(f"| `{name(cls)}` | {verdict} | {meaning} | {below} |".replace("  |", " |"))
        out.append("")
    return "\n".join(out) + OPEN + FOUND + TRAFFIC + DISTRIBUTIONS


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
