"""Entities: vehicles, pedestrians, other objects, their controllers, and selections of them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Final, Literal, TypeAlias

from openscenario.model.declarations import NO_PROPERTIES, ParameterDeclaration, Properties
from openscenario.model.enums import (
    ControllerType,
    MiscObjectCategory,
    ObjectType,
    PedestrianCategory,
    Role,
    VehicleCategory,
)
from openscenario.model.kinds import (
    Element,
    EntityName,
    Length,
    Mass,
    MaxAcceleration,
    MaxJerk,
    MaxSpeed,
    Metre,
    NonNegativeRadian,
    PositiveLength,
    TrailerName,
    xml,
)

EntityKind: TypeAlias = Literal["vehicle", "pedestrian", "misc", "external"]


@dataclass(frozen=True, slots=True)
class Center(Element):
    """Centre of the box in the entity's frame [m]; the reference point of a vehicle is its rear axle's ground point."""

    x: Metre
    y: Metre
    z: Metre


@dataclass(frozen=True, slots=True)
class Dimensions(Element):
    width: Length
    length: Length
    height: Length


@dataclass(frozen=True, slots=True)
class BoundingBox(Element):
    center: Center
    dimensions: Dimensions


@dataclass(frozen=True, slots=True)
class Performance(Element):
    """Limits [m/s], [m/s^2], [m/s^3], all as magnitudes; absent rates are unlimited."""

    max_speed: MaxSpeed
    max_acceleration: MaxAcceleration
    max_deceleration: MaxAcceleration
    max_acceleration_rate: MaxJerk | None = None
    max_deceleration_rate: MaxJerk | None = None


@dataclass(frozen=True, slots=True)
class Axle(Element):
    """`position_x`, `position_z` [m] from the rear axle's ground point; `max_steering` [rad]."""

    max_steering: NonNegativeRadian
    wheel_diameter: PositiveLength
    track_width: Length
    position_x: Metre
    position_z: Metre


@dataclass(frozen=True, slots=True)
class Axles(Element):
    """A trailer may have no front axle."""

    front_axle: Axle | None
    rear_axle: Axle
    additional_axles: tuple[Axle, ...] = field(metadata=xml("AdditionalAxle"), default=())


@dataclass(frozen=True, slots=True)
class TrailerHitch(Element):
    dx: Metre
    dz: Metre = 0.0


@dataclass(frozen=True, slots=True)
class TrailerCoupler(Element):
    dx: Metre
    dz: Metre = 0.0


@dataclass(frozen=True, slots=True)
class TrailerRef(Element):
    """Names the entity that hangs behind; catalogues name trailers that a scenario may well not have."""

    entity_ref: TrailerName


@dataclass(frozen=True, slots=True)
class Trailer(Element):
    """Exactly one of the two: a trailer of its own, or another entity of the scenario."""

    trailer: ScenarioObject | None = None
    trailer_ref: TrailerRef | None = None


@dataclass(frozen=True, slots=True)
class Vehicle(Element):
    name: str
    vehicle_category: VehicleCategory
    bounding_box: BoundingBox
    performance: Performance
    axles: Axles
    mass: Mass | None = None
    role: Role = "none"
    model3d: str = ""
    properties: Properties = NO_PROPERTIES
    trailer_hitch: TrailerHitch | None = None
    trailer_coupler: TrailerCoupler | None = None
    trailer: Trailer | None = None
    parameter_declarations: tuple[ParameterDeclaration, ...] = field(
        metadata=xml("ParameterDeclarations/ParameterDeclaration"), default=()
    )


@dataclass(frozen=True, slots=True)
class Pedestrian(Element):
    name: str
    pedestrian_category: PedestrianCategory
    mass: Mass
    bounding_box: BoundingBox
    role: Role = "none"
    model: str = ""
    model3d: str = ""
    properties: Properties = NO_PROPERTIES
    parameter_declarations: tuple[ParameterDeclaration, ...] = field(
        metadata=xml("ParameterDeclarations/ParameterDeclaration"), default=()
    )


@dataclass(frozen=True, slots=True)
class MiscObject(Element):
    name: str
    misc_object_category: MiscObjectCategory
    mass: Mass
    bounding_box: BoundingBox
    model3d: str = ""
    properties: Properties = NO_PROPERTIES
    parameter_declarations: tuple[ParameterDeclaration, ...] = field(
        metadata=xml("ParameterDeclarations/ParameterDeclaration"), default=()
    )


@dataclass(frozen=True, slots=True)
class ExternalObjectReference(Element):
    name: str


EntityObject: TypeAlias = Vehicle | Pedestrian | MiscObject | ExternalObjectReference

_KINDS: dict[type, EntityKind] = {Vehicle: "vehicle", Pedestrian: "pedestrian", MiscObject: "misc"}


@dataclass(frozen=True, slots=True)
class Controller(Element):
    name: str
    controller_type: ControllerType = "movement"
    properties: Properties = NO_PROPERTIES
    parameter_declarations: tuple[ParameterDeclaration, ...] = field(
        metadata=xml("ParameterDeclarations/ParameterDeclaration"), default=()
    )


@dataclass(frozen=True, slots=True)
class ObjectController(Element):
    """A controller given to an entity; `name` is what ActivateControllerAction refers to since 1.3."""

    controller: Controller | None = field(metadata=xml("Controller", catalog=True), default=None)
    name: str = ""


@dataclass(frozen=True, slots=True)
class ScenarioObject(Element):
    name: str
    entity: EntityObject = field(metadata=xml(inline=True, catalog=True))
    object_controllers: tuple[ObjectController, ...] = ()

    @property
    def kind(self) -> EntityKind:
        """What the entity is: vehicle, pedestrian, misc or external."""
        return _KINDS.get(type(self.entity), "external")

    @property
    def category(self) -> str:
        """The category of its kind: car, truck, pedestrian, obstacle, ...; empty for an external object."""
        match self.entity:
            case Vehicle(vehicle_category=category):
                return category
            case Pedestrian(pedestrian_category=category_of_pedestrian):
                return category_of_pedestrian
            case MiscObject(misc_object_category=category_of_object):
                return category_of_object
        return ""

    @property
    def bounding_box(self) -> BoundingBox | None:
        """The box around the entity; None for an external object."""
        return None if isinstance(self.entity, ExternalObjectReference) else self.entity.bounding_box


@dataclass(frozen=True, slots=True)
class EntityRef(Element):
    entity_ref: EntityName


@dataclass(frozen=True, slots=True)
class ByObjectType(Element):
    XML = "ByType"

    type: ObjectType


@dataclass(frozen=True, slots=True)
class ByType(Element):
    object_type: ObjectType


@dataclass(frozen=True, slots=True)
class SelectedEntities(Element):
    """The listed entities, or all of the listed types."""

    entity_refs: tuple[EntityRef, ...] = ()
    by_types: tuple[ByType, ...] = ()


@dataclass(frozen=True, slots=True)
class EntitySelection(Element):
    """A named group of entities."""

    name: str
    selected: SelectedEntities = field(metadata=xml("Members"))

    @property
    def members(self) -> tuple[EntityRef | ByType, ...]:
        """The listed entities and types, in one row."""
        return self.selected.entity_refs + self.selected.by_types


@dataclass(frozen=True, slots=True)
class Entities(Element):
    scenario_objects: tuple[ScenarioObject, ...] = ()
    entity_selections: tuple[EntitySelection, ...] = ()


EGO_OF_CARLA: Final = ("hero", "ego_vehicle")  # as its scenario runner and its ROS bridge call the vehicle under test


def ego_among(names: Iterable[str]) -> str | None:
    """The name of the vehicle under test: `Ego` in any case, else as CARLA calls it; None if no entity is called so."""
    known = list(names)
    own = [name for name in known if name.lower() == "ego"]
    return next((name for name in (*own, *EGO_OF_CARLA) if name in known), None)
