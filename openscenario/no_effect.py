"""What a scenario asks for that is read, checked and then changes nothing here: said, so that nobody relies on it."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from types import MappingProxyType

from openscenario import model
from openscenario.findings import Finding

_CONTROLLER = "others keep the default controller, the ego its driving stack"

NO_EFFECT: Mapping[type, str] = MappingProxyType(
    {
        model.ActivateControllerAction: _CONTROLLER,
        model.ControllerAction: _CONTROLLER,
        model.VisibilityAction: "no sensor model sees it",
        model.EnvironmentAction: "neither motion nor sensors depend on it; conditions on the time of day do",
        model.CustomCommandAction: "a scenario must not run programs",
        model.SetMonitorAction: "monitors are for whoever watches",
    }
)
"""Actions of that kind, and why."""


def without_effect(scenario: model.Scenario) -> tuple[Finding, ...]:
    """A warning for each kind of such an action and file, at the first of them."""
    first: dict[tuple[type, str], model.Element] = {}
    count: dict[tuple[type, str], int] = {}
    for element in _elements(scenario.storyboard):
        if type(element) in NO_EFFECT:
            key = (type(element), element.at.file)
            first.setdefault(key, element)
            count[key] = count.get(key, 0) + 1
    return tuple(
        Finding(
            "dvp.no_effect",
            "warning",
            element.at.file,
            element.at.line or None,
            element.at.element,
            text=f"accepted, no effect here: {key[0].__name__}"
            + (f", {count[key]} times, first here" if count[key] > 1 else ""),
            hint=NO_EFFECT[key[0]],
        )
        for key, element in first.items()
    )


def _elements(thing: object) -> Iterator[model.Element]:
    """All elements below, in the order of the file."""
    if isinstance(thing, tuple):
        for each in thing:
            yield from _elements(each)
    elif isinstance(thing, model.Element):
        yield thing
        for field in dataclasses.fields(thing):
            yield from _elements(getattr(thing, field.name))
