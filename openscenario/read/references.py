"""Names that elements refer to: entities, parameters, variables, monitors, signal controllers, storyboard elements."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from openscenario.criteria import criterion_of
from openscenario.findings import listed, nearest
from openscenario.model.kinds import RefKind
from openscenario.read.context import Context, Reference
from openscenario.values import BadValue, check_type

STORYBOARD_TYPES: Final = ("story", "act", "maneuverGroup", "maneuver", "event", "action")

WITHOUT_SUMS: Final = ("string", "boolean", "dateTime")
NUMBERS: Final = "double, int, unsignedInt, unsignedShort"

_WHAT: Final[Mapping[RefKind, tuple[str, str]]] = {
    "entity": ("reference_control.resolvable_entity_references", "entity"),
    "trailer": ("ref.unknown_trailer", "entity to be the trailer: it drives without one"),
    "parameter": ("param.undefined", "parameter"),
    "variable": ("reference_control.resolvable_variable_reference", "variable"),
    "monitor": ("ref.unknown_monitor", "monitor"),
    "signal_controller": ("ref.unknown_signal_controller", "traffic signal controller"),
    "storyboard": ("reference_control.resolvable_storyboard_element_reference", "storyboard element"),
}


def check_references(context: Context) -> None:
    """Notes every reference to a name that nothing has, with the nearest name."""
    known: dict[RefKind, dict[str, None]] = {
        "entity": context.named("entity"),
        "trailer": context.named("entity"),
        "parameter": context.named("parameter"),
        "variable": context.named("variable"),
        "monitor": context.named("monitor"),
        "signal_controller": context.named("signal_controller"),
        "storyboard": context.named(*STORYBOARD_TYPES),
    }
    for reference in context.references:
        if _last(reference) not in known[reference.kind]:
            code, what = _WHAT[reference.kind]
            names = known[reference.kind]
            if reference.kind == "parameter" and (criterion := criterion_of(reference.at)):
                text = "a criterion of CARLA's scenario runner is no condition: it is never true here"
                hint = "gates judge a drive: docs/metrics.md"
                context.warning("condition.criterion", reference.at, "", text, found=criterion, hint=hint)
                continue
            note = context.warning if reference.kind == "trailer" else context.error
            note(
                code,
                reference.at,
                f"@{reference.attribute}",
                f"no such {what}",
                found=reference.name,
                allowed=listed(sorted(names)) or "none is declared",
                hint="; ".join(filter(None, (reference.origin, nearest(_last(reference), names)))),
            )
    _check_types(context)


def check_types(context: Context, types: Mapping[tuple[RefKind, str], str]) -> None:
    """Notes values that are none of the type that their parameter or variable is declared with."""
    for value in context.typed_values:
        kind = types.get((value.kind, value.name.removeprefix("$")))
        if value.value is None:
            if kind in WITHOUT_SUMS:
                text = f"{value.kind} {value.name!r} is no number: nothing can be added to it or multiplied with it"
                context.error("value.not_a_number", value.at, "", text, found=kind, allowed=NUMBERS)
            continue
        try:
            check_type(value.value, kind or "string")
        except BadValue as error:
            text = f"{error.text}: {value.kind} {value.name!r} is declared as {kind}"
            context.error(error.code, value.at, "@value", text, found=value.value, allowed=error.allowed)


def check_entity_names(context: Context) -> None:
    """Entities and selections share one set of names."""
    first: dict[str, int] = {}
    for name, at in context.names.get("entity", ()):
        if name in first:
            context.error(
                "name.duplicate", at, "@name", "the name is taken", found=name, hint=f"first used in line {first[name]}"
            )
        first.setdefault(name, at.line)


def _last(reference: Reference) -> str:
    """The name itself: a parameter without its `$`, a storyboard element without the path `Story::Act::` before it."""
    if reference.kind == "parameter":
        return reference.name.removeprefix("$")
    return reference.name.split("::")[-1] if reference.kind == "storyboard" else reference.name


def _check_types(context: Context) -> None:
    """A condition on the event X where X is an act would wait for ever."""
    everything = context.named(*STORYBOARD_TYPES)
    for condition in context.state_conditions:
        name = condition.storyboard_element_ref.split("::")[-1]
        if name in everything and name not in context.named(condition.storyboard_element_type):
            types = [kind for kind in STORYBOARD_TYPES if name in context.named(kind)]
            context.error(
                "reference_control.resolvable_storyboard_element_reference",
                condition.at,
                "@storyboardElementType",
                f"'{name[:60]}' is of another type",
                found=condition.storyboard_element_type,
                allowed=", ".join(types),
            )
