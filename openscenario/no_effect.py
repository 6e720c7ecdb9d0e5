"""What a scenario asks for that is read, checked and then changes nothing here: said, so that nobody relies on it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from types import MappingProxyType

from openscenario import model
from openscenario.findings import Finding
from openscenario.interactive import is_interactive
from openscenario.model.entities import ego_among
from openscenario.model.kinds import elements_below

_CONTROLLER = "others keep the default controller, the ego its driving stack"
NO_EFFECT: Mapping[type, str] = MappingProxyType(
    {
        model.CustomCommandAction: "a scenario must not run programs",
    }
)
"""Actions of that kind, and why."""

_OF_WEATHER: Mapping[type, str] = MappingProxyType(
    {
        model.DomeImage: "nothing is drawn from the scenario while it runs",
    }
)
SENSORS = ("lidar", "camera")
"""Sensors of the driven car that see what is around, as a SensorReference may name them."""


def without_effect(scenario: model.Scenario) -> tuple[Finding, ...]:
    """A warning for each kind of such an element and file, at the first of them."""
    first: dict[tuple[str, str, str], model.Element] = {}
    count: dict[tuple[str, str, str], int] = {}
    elements = list(elements_below(scenario.storyboard))
    reacting = _reacts(scenario, elements)
    for element in elements:
        for what, why in (*_idle(element), *(() if reacting else _controller(element))):
            key = (what, why, element.at.file)
            first.setdefault(key, element)
            count[key] = count.get(key, 0) + 1
    return tuple(
        Finding(
            "dvp.no_effect",
            "warning",
            element.at.file,
            element.at.line or None,
            element.at.element,
            text=f"accepted, no effect here: {key[0]}"
            + (f", {count[key]} times, first here" if count[key] > 1 else ""),
            hint=key[1],
        )
        for key, element in first.items()
    )


def _idle(element: model.Element) -> Iterator[tuple[str, str]]:
    """What of an element changes nothing, and why."""
    if type(element) in NO_EFFECT:
        yield type(element).__name__, NO_EFFECT[type(element)]
    elif isinstance(element, model.VisibilityAction):
        if not element.graphics:
            yield "VisibilityAction graphics", "nothing is drawn from the scenario while it runs"
        for each in element.sensor_references:
            if each.name.lower() not in SENSORS:
                yield f"SensorReference {each.name[:40]}", f"sensors are called {' and '.join(SENSORS)} here"
    elif isinstance(element, model.SpeedProfileAction) and element.following_mode == "position":
        limits = element.dynamic_constraints
        rates = (limits.max_acceleration_rate, limits.max_deceleration_rate) if limits is not None else (None, None)
        if rates != (None, None):
            yield "limits of jerk in a SpeedProfileAction", "mode position is strictly linear; mode follow obeys them"
    elif isinstance(element, model.TransitionDynamics) and element.following_mode is not None:
        yield "followingMode of a transition", "the shape is kept as far as the Performance allows, in either mode"
    elif type(element) in _OF_WEATHER:
        yield f"{type(element).__name__} of an environment", _OF_WEATHER[type(element)]
    elif isinstance(element, model.Precipitation) and _is_unknown(element):
        yield (
            "intensity of a Precipitation",
            "only precipitationIntensity [mm/h] of rain and snow says how far one sees",
        )
    elif isinstance(element, model.RoadCondition) and element.friction_scale_factor > 1.0:
        yield "a frictionScaleFactor above 1", "the road that the vehicle model was made for is the best there is"
    elif isinstance(element, model.Waypoint) and element.route_strategy != "shortest":
        yield f"routeStrategy {element.route_strategy}", "routes are the shortest"
    elif getattr(element, "routing_algorithm", "undefined") != "undefined":
        yield "routingAlgorithm of a condition", "distances along roads are measured the same way whatever it says"
    elif isinstance(element, model.GeoPosition) and element.vertical_road_selection != 0:
        yield "verticalRoadSelection", "of roads above each other the position takes the nearest"


def _reacts(scenario: model.Scenario, elements: Iterable[model.Element]) -> bool:
    """Whether a controller of the scenario, other than that of the vehicle under test, reacts to traffic."""
    ego = ego_among([each.name for each in scenario.entities])
    given = [own.controller for each in scenario.entities if each.name != ego for own in each.object_controllers]
    for element in elements:
        if isinstance(element, model.AssignControllerAction):
            own = element.object_controller
            given.append(element.controller if own is None else own.controller)
    return any(is_interactive(each) for each in given)


def _controller(element: model.Element) -> Iterator[tuple[str, str]]:
    """A controller that is assigned or activated where none does anything here."""
    if isinstance(element, model.ActivateControllerAction | model.AssignControllerAction):
        yield type(element).__name__, _CONTROLLER


def _is_unknown(rain: model.Precipitation) -> bool:
    """Whether something falls that says nothing of how far one sees."""
    return rain.precipitation_type != "dry" and rain.precipitation_intensity is None
