"""Rules of what stands on a road: signals and objects lie on it, sizes are sizes, references lead somewhere."""

from __future__ import annotations

import math
from collections.abc import Iterator

from openscenario.findings import listed
from openscenario.road.attributes import Attributes
from openscenario.road.object_reader import LEFT_OUT, is_dynamic
from openscenario.xml import Node

BEYOND = 1.0  # m, that a thing may lie before or behind its road: what stands at a corner belongs to one of two roads
_CHOICES = {"orientation": ("+", "-", "none"), "dynamic": ("yes", "no")}
_SIZES = ("length", "width", "height", "radius", "validLength")


def check_things(attributes: Attributes, roads: list[Node]) -> None:
    """Add a finding for each signal or object that cannot be what it says; `roads` are the road elements."""
    root = roads[0].parent
    signals = {node.get("id") for _, node in _things(roads) if node.tag == "signal"}
    objects = {node.get("id") for _, node in _things(roads) if node.tag == "object"}
    seen: set[tuple[str, str]] = set()
    for length, node in _things(roads):
        with attributes.repairing(LEFT_OUT):
            _place(attributes, node, length)
        _choices(attributes, node)
        _validity(attributes, node)
        known = {"signalReference": signals, "objectReference": objects}.get(node.tag)
        if known is not None:
            _known(attributes, node, "id", known)
        elif (node.tag, node.get("id")) in seen:
            attributes.report(
                f"asam.net:xodr:1.4.0:road.{node.tag}.id_unique",
                node,
                f"another {node.tag} has this id",
                attribute="id",
                found=node.get("id"),
                severity="warning",
            )
        seen.add((node.tag, node.get("id")))
    for controller in [] if root is None else root.findall("controller"):
        for control in controller.findall("control"):
            _known(attributes, control, "signalId", signals)


def _things(roads: list[Node]) -> Iterator[tuple[float, Node]]:
    """Length of the road [m] and element of all that stands on it."""
    for road in roads:
        for group in road.children:
            if group.tag in ("objects", "signals"):
                length = float(road.get("length"))
                yield from ((length, node) for node in group.children if node.tag[:6] in ("object", "signal"))


def _choices(attributes: Attributes, node: Node) -> None:
    """A word that is none leaves the thing where it is: what is assumed of it says what its reader takes it for."""
    assumed = {
        "orientation": "it is for both directions",
        "dynamic": "it is dynamic" if is_dynamic(node) else "it is not dynamic",
    }
    for name, allowed in _CHOICES.items():
        with attributes.repairing(assumed[name]):
            attributes.choice(node, name, allowed, "") if node.get(name) else None


def _validity(attributes: Attributes, node: Node) -> None:
    """A signal is for lanes that its road has; from 0 to 0 is for none, and meant so."""
    ranges = [(_number(each.get("fromLane")), _number(each.get("toLane"))) for each in node.findall("validity")]
    road = node.parent.parent if ranges and node.parent is not None else None
    if road is None or any(math.isnan(first + last) or first == last == 0.0 for first, last in ranges):
        return
    sections = [section for group in road.findall("lanes") for section in group.findall("laneSection")]
    ids = {_number(lane.get("id")) for section in sections for side in section.children for lane in side.children}
    if not any(min(one) <= lane <= max(one) for one in ranges for lane in ids if lane):
        attributes.report(
            "road.validity_unknown",
            node,
            f"the {node.tag} is for no lane of its road: nobody obeys it",
            found=", ".join(f"{first:g} to {last:g}" for first, last in ranges),
            allowed=listed([f"{lane:g}" for lane in sorted(ids) if lane]),
            severity="warning",
        )


def _place(attributes: Attributes, node: Node, length: float) -> None:
    s = attributes.number(node, "s", 0.0)
    if not -BEYOND <= s <= length + BEYOND:
        attributes.report(
            "road.s_out_of_range",
            node,
            f"the {node.tag} lies beyond its road",
            attribute="s",
            found=node.get("s"),
            allowed=f"0 to {length:g} m",
            repair="it stands there",
        )
    for name in _SIZES:
        # the words that stand for no size, and what is no number, are for the reader
        if name in node.attributes and _number(node.get(name)) < 0.0:
            attributes.report(
                "value.out_of_range",
                node,
                "a size is not negative",
                attribute=name,
                found=node.get(name),
                allowed=">= 0 m",
                repair="it has no such size",
            )


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def _known(attributes: Attributes, node: Node, name: str, known: set[str]) -> None:
    if node.get(name) not in known:
        allowed, hint = attributes.advice(node.get(name), known)
        attributes.report(
            f"asam.net:xodr:1.4.0:road.{node.tag}.unknown",
            node,
            "the reference leads nowhere",
            attribute=name,
            found=node.get(name),
            allowed=allowed,
            hint=hint,
            repair="the reference is left out",
        )
