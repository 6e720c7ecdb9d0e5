"""What the fields of the model mean: place, quantity with unit and bounds, reference, XML spelling where it differs.

The dataclasses of this package are the one table that reading, checking and writing work from: a field `lane_id` is the
attribute `laneId`, a field `performance: Performance` the child `<Performance>`, a field `position: Position` (a union)
the child `<Position>` that holds one of the union's elements, a `tuple[Event, ...]` the repeated child `<Event>`. What
differs from this is said by `xml(...)` at the field or by `XML` at the class.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal, TypeAlias


@dataclass(frozen=True, slots=True)
class At:
    """Where an element was read: file, 1-based line of its start tag, element path."""

    file: str = ""
    line: int = 0
    element: str = ""


NOWHERE = At()


@dataclass(frozen=True, slots=True)
class Element:
    """Anything read from a file; `at` tells where and takes no part in comparisons."""

    XML: ClassVar[str] = ""  # path of the element below its choice, if not simply the class name

    at: At = dataclasses.field(default=NOWHERE, compare=False, repr=False, kw_only=True)


def elements_below(thing: object) -> Iterator[Element]:
    """An element, or those of a tuple, and all elements below, in the order of the file; none for anything else."""
    if isinstance(thing, tuple):
        for each in thing:
            yield from elements_below(each)
    elif isinstance(thing, Element):
        yield thing
        for field in dataclasses.fields(thing):
            yield from elements_below(getattr(thing, field.name))


@dataclass(frozen=True, slots=True)
class Quantity:
    """Unit and bounds of a number: low <= x <= high, x > above; `rule`: the ASAM rule that says so, if there is one.

    `endless`: a limit, which may be INF.
    """

    unit: str
    low: float | None = None
    high: float | None = None
    above: float | None = None
    rule: str = "value.out_of_range"
    endless: bool = False


@dataclass(frozen=True, slots=True)
class Moment:
    """A date and time in ISO 8601."""


@dataclass(frozen=True, slots=True)
class Raw:
    """Text that is kept as written: parameters in it are resolved later, in the scope that it opens."""


RefKind = Literal["entity", "trailer", "parameter", "variable", "monitor", "signal_controller", "storyboard"]


@dataclass(frozen=True, slots=True)
class Ref:
    """A name that must be declared elsewhere in the scenario."""

    kind: RefKind


@dataclass(frozen=True, slots=True)
class Xml:
    """How a field is spelled in the file, where its name does not say it.

    `path`: tags below the element (`TrajectoryRef/Trajectory`), or the attribute's name; `former`: older spellings,
    read and not written; `inline`: the union's elements stand directly in it; `catalog`: a CatalogReference may stand
    in their place; `text`: the text between the tags.
    """

    path: str = ""
    former: tuple[str, ...] = ()
    inline: bool = False
    catalog: bool = False
    text: bool = False


def xml(
    path: str = "",
    *,
    former: tuple[str, ...] = (),
    inline: bool = False,
    catalog: bool = False,
    text: bool = False,
) -> dict[str, Xml]:
    """Metadata for `dataclasses.field`: how the field is spelled in the file."""
    return {"xml": Xml(path, former, inline, catalog, text)}


Metre: TypeAlias = Annotated[float, Quantity("m")]
Length: TypeAlias = Annotated[float, Quantity("m", low=0.0)]
PositiveLength: TypeAlias = Annotated[float, Quantity("m", above=0.0)]
Second: TypeAlias = Annotated[float, Quantity("s")]
Duration: TypeAlias = Annotated[float, Quantity("s", low=0.0)]
PhaseDuration: TypeAlias = Annotated[float, Quantity("s", low=0.0, rule="data_type.positive_duration_in_phase")]
TransitionTime: TypeAlias = Annotated[
    float, Quantity("s", low=0.0, rule="data_type.non_negative_transition_time_in_light_state_action")
]
Speed: TypeAlias = Annotated[float, Quantity("m/s", low=-1e4, high=1e4)]
# an integration step of 1 ms still holds there, three times the speed of sound; tornadoes reach 140 m/s
WindSpeed: TypeAlias = Annotated[float, Quantity("m/s", low=0.0, high=1e3)]
MaxSpeed: TypeAlias = Annotated[float, Quantity("m/s", low=0.0, endless=True)]
Acceleration: TypeAlias = Annotated[float, Quantity("m/s^2")]
MaxAcceleration: TypeAlias = Annotated[float, Quantity("m/s^2", low=0.0, endless=True)]
MaxJerk: TypeAlias = Annotated[float, Quantity("m/s^3", low=0.0, endless=True)]
VisualRange: TypeAlias = Annotated[float, Quantity("m", low=0.0, endless=True)]
Radian: TypeAlias = Annotated[float, Quantity("rad")]
NonNegativeRadian: TypeAlias = Annotated[float, Quantity("rad", low=0.0)]
Latitude: TypeAlias = Annotated[float, Quantity("deg", low=-90.0, high=90.0)]
Longitude: TypeAlias = Annotated[float, Quantity("deg", low=-180.0, high=180.0)]
Curvature: TypeAlias = Annotated[float, Quantity("1/m")]
Mass: TypeAlias = Annotated[float, Quantity("kg", low=0.0)]
Share: TypeAlias = Annotated[float, Quantity("1", low=0.0, high=1.0)]
Weight: TypeAlias = Annotated[float, Quantity("1", low=0.0)]
Number: TypeAlias = Annotated[float, Quantity("1")]
NonNegative: TypeAlias = Annotated[float, Quantity("1", low=0.0)]
Count: TypeAlias = Annotated[int, Quantity("1", low=0.0)]
Executions: TypeAlias = Annotated[int, Quantity("1", low=1.0)]
Scale: TypeAlias = Annotated[float, Quantity("1", above=0.0)]

RawText: TypeAlias = Annotated[str, Raw()]
DateTime: TypeAlias = Annotated[str, Moment()]
EntityName: TypeAlias = Annotated[str, Ref("entity")]
TrailerName: TypeAlias = Annotated[str, Ref("trailer")]
ParameterName: TypeAlias = Annotated[str, Ref("parameter")]
VariableName: TypeAlias = Annotated[str, Ref("variable")]
MonitorName: TypeAlias = Annotated[str, Ref("monitor")]
SignalControllerName: TypeAlias = Annotated[str, Ref("signal_controller")]
StoryboardName: TypeAlias = Annotated[str, Ref("storyboard")]
