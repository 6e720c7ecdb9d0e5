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

OpenSCENARIO XML {_VERSIONS}; what older versions spell otherwise (`overwrite`,
`velocity`, ...) reads the same. This page is made by `python -m scripts.make_openscenario_page`.

- **run**: acts as the standard says.
- **accepted**: read, checked, written back; it changes nothing here, or what the row says.
- **refused**: an error finding with file and line, from `dvp play` and `dvp run` before anything moves; a file with it
  is never run without it. `dvp check` reports what is wrong in itself, not what is merely refused by the storyboard.

A warning of `dvp check` (exit code 0) is what runs and hardly means what it says: a shape that has no time for it
(`value.no_transition`), and a scenario that nothing in it ever ends (`storyboard.never_ends`): no stop trigger that can
become true, and an act that can never end. That is said only of what follows from the file: times before the beginning,
parameters that nothing sets, elements that wait for such or for each other, actions without an end of their own.

The column "with" names what belongs to an element and shares its fate. What stands nowhere on this page is no element
of the standard, and an error finding. OpenSCENARIO DSL (`.osc`), lanelet2, CommonRoad and SUMO are refused by name.
"""

DISTRIBUTIONS = """
## Parameter distributions

A file with a `ParameterValueDistribution` is a set of runs of its `ScenarioFile`. This one, `speeds.xosc`, is five runs
of `overtaking.xosc` with its parameter `oncoming_speed` at 2, 3, 4, 5 and 6:

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
pytest speeds.xosc                    # an item a case: speeds.xosc::dt[3-oncoming_speed=4]
pytest speeds.xosc --dvp-cases 50     # a random sample of 50, the same for the same --dvp-seed
dvp run speeds.xosc --cases 50
dvp check speeds.xosc                 # how many cases; unknown parameters, values outside constraints, step 0, ...
```

More than 1000 cases run only when `--cases` says how many. A deterministic distribution is every combination of its
values, the last distribution of the file changing fastest; its number is computed, no case is built for it. A range
holds its upper limit if a step ends there, counted in decimals (1.1 to 1.5 by 0.2 is three values).

A stochastic distribution draws `numberOfTestRuns` cases from its `randomSeed` (without one: from `--seed`); the draw of
a case depends on the seed, the parameter's name and the number of the case alone. `LogNormalDistribution` has the
expected value and variance of the log-normal distribution itself, not of its logarithm. Drawn values for whole
parameters are rounded to the nearest.

Each case is judged by the gates beside the distribution (`speeds.gates.toml`), else by those beside its scenario, and
its run folder is called after the distribution and the number of the case (`runs/0012-speeds-07-dt`). Cases run on the
digital twin only: what is varied automatically never drives a real car.

In Python: `openscenario.read.read_cases(path)` gives `count`, `cases[n]` and an iterator.
"""

OPEN = """
## Where the standard leaves the meaning open

What the widely used tools do, where they agree with each other or nothing speaks against it:

- `SynchronizeAction` names no speed profile: ramps of constant acceleration, one if it fits, else two. The master's
  pace is that of its last motion; being put somewhere is none. So at t = 0, and in the instant in which a trajectory
  takes the master over, the master stands; who has a final speed stands as well, until the last ramp fits.
- `SpeedAction`, relative to another entity and not `continuous`: the target moves with that entity until it is reached;
  relative to oneself it is that of the start. `time`: after it the target of then is reached. `rate`: so the speed goes
  there, and never faster. `distance`: on all of it. A step sets the speed at once, at the start only; after that, as
  everywhere, a vehicle changes its speed no faster than its `Performance` says, whichever `followingMode` is given.
- `SpeedProfileAction`: limits are those of its `DynamicConstraints`, and of the vehicle's `Performance` where they have
  none. Where they need more time than an entry gives, it and all that follow come later, with a warning; speeds beyond
  `maxSpeed` are cut to it. Mode `position`: straight lines, which no limit of jerk applies to. Mode `follow`: each
  corner is a parabola of the allowed jerk; where there is no room for that, each entry is reached by itself, with no
  acceleration there. An `entityRef`: its speed at the start. Present accelerations do not jump.
- `DynamicConstraints` of the two distance actions: the narrower of them and, along the road, of the `Performance`;
  limits of jerk apply to accelerating or braking harder, not to letting go. Without any the entity is put there, and
  kept there no faster than the vehicle's `maxSpeed`.
- `RelativeLanePosition` with neither `ds` nor `dsLane`, both optional since 1.1: beside the other entity, as with `ds`
  of 0 (lanes and offset are those of the road). With both it is refused.
- `LaneOffsetAction`, continuous and relative to another entity: `maxLateralAcc` holds on the way and afterwards; who
  follows comes later where the other moves over harder.
- `TeleportAction`: the default controller goes on from there 10 ms later; other actions at once.
- Where a lane ends and its road goes on, here or as the road linked there, the default controller goes on in the
  nearest lane of the same side; where the road ends it stops.
- `LightStateAction`: flashing has no regular ending, as an animation in a loop has none; an action on the same light of
  the same entity stops it. On and off end with the transition time.
- `freespace` distances to or from who draws trailers are those of the nearest parts: a trailer belongs to its vehicle.
- `alongRoute` (deprecated): the distance with turns of the road straightened out; what lies to the side counts, as in
  the straight line that `false` means.
- NURBS with time stamps: a control point's time is that of the place of its greatest influence, or of the last whole
  metre of the control polygon before it; between, time runs evenly in the curve's parameter.
- `LateralDistanceAction` names no law. Across a road: a critically damped spring; in entity coordinates: steering for
  the line beside the other entity, with a turning radius of 1.5 v²/a, and into that entity's direction.
- Distances in the coordinates of a trajectory are there while who measures them follows one; else infinite.
- Following mode `follow`: constant acceleration between the time stamps of a polyline, and even turning; `position`:
  constant speed between them, turning at the vertices.

Where the standard is explicit it is followed, whatever other tools do, but for three rules that scenarios of the field
are written for: those go by esmini unless `--reading standard` is given, with a warning where it mattered.
`docs/conformance.md` quotes the clauses.
"""

TRAFFIC = """
## Traffic that comes and goes

`TrafficAction` puts entities called `NAME-1`, `NAME-2`, ... (`traffic-1` without a `trafficName`) on driving lanes, in
the direction of the lane, where there is room behind and ahead: fewer than asked for if there is none, 300 at most.
Everything is drawn from the seed: the same seed, the same traffic. They are entities like others: in `dvp play`'s rows,
before the sensors of the stack under test, in conditions on any entity or on a type.

- **How they drive** the standard leaves to controllers, which are not run here: in the middle of their lane, straight
  on where roads part, behind others by the intelligent driver model (Treiber et al. 2000; 1.5 m/s², 2 m/s², 1.5 s, 2 m)
  with the speed they came with. No lane changes, no right of way. At the end of their lane they are gone.
- **What they are**: templates of a `TrafficDistribution` by weight (1.3), categories of a `TrafficDefinition` by weight
  (until 1.2) as vehicles of usual size, else cars. Roles and controllers change nothing.
- `TrafficSourceAction`: one more every 1 / `rate` seconds within the radius, all lanes in it, or on the nearest lane;
  with the speed given, else the limit of the lane, else 50 km/h.
- `TrafficSinkAction`: takes such traffic out of its radius; an entity that the file names stays.
- `TrafficSwarmAction`: keeps the number in the ellipse that moves with the central entity; nobody appears in the inner
  circle, who leaves the ellipse is gone.
- `TrafficAreaAction`: fills a polygon or a stretch of a road once, or keeps the number in it (`continuous`). A
  `RoadRange` over several roads is refused.
- `TrafficStopAction`: nobody comes or goes any more by the action of that name, or by any; who is there drives on.
"""

MEANING: Mapping[type[Element], tuple[str, str]] = {
    model.FileHeader: (RUN, "decides the version; license and properties are kept"),
    model.ParameterDeclaration: (RUN, "with constraint groups, expressions and scopes; set from outside by `--set`"),
    model.VariableDeclaration: (RUN, ""),
    model.MonitorDeclaration: (ACCEPTED, "monitors are for whoever watches the simulation"),
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
    model.ObjectController: (ACCEPTED, "the ego is driven by the stack under test, others by the default controller"),
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
    model.Environment: (ACCEPTED, "kept for whoever wants to know; motion does not depend on it"),
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
    return "\n".join(out) + OPEN + TRAFFIC + DISTRIBUTIONS


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
