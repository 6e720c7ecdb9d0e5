"""Petri nets as drawings: places in a column, transitions as bars beside them, one arc for each token that moves.

Transitions that lead on (to a later place) stand at the right, those that lead back at the left. Everything is computed
here; the template only writes it down.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

WIDTH = 640.0  # px
MIDDLE = 0.5 * WIDTH
RADIUS = 30.0  # px of a place
PITCH = 74.0  # px between places
SLOT = 46.0  # px between transitions of one side
BAR = 118.0  # px from the middle to a bar
TOP = 34.0  # px
GUARD_LETTERS = 30  # letters of a guard a line has room for


@dataclasses.dataclass(frozen=True)
class Place:
    """A circle. `share`: of the run's time that it was active, None if the log does not tell."""

    name: str
    action: str
    y: float
    initial: bool
    share: float | None


@dataclasses.dataclass(frozen=True)
class Bar:
    """A transition: its bar at (x, y), words beside it, arcs as SVG path data and whether each has an arrow head."""

    name: str
    guard: tuple[str, ...]
    x: float
    y: float
    text_x: float
    anchor: str
    arcs: tuple[tuple[str, bool], ...]


@dataclasses.dataclass(frozen=True)
class Drawing:
    """One net, ready to be written as SVG."""

    name: str
    parent: str
    width: float
    height: float
    places: tuple[Place, ...]
    bars: tuple[Bar, ...]


def drawings(nets: Sequence[Mapping[str, Any]], shares: Mapping[tuple[str, str], float]) -> list[Drawing]:
    """Drawings of nets as the log's meta holds them; `shares` of the time by (net, place).

    A net is {"name", "parent", "initial": [place], "places": {place: action}, "transitions": [{"name", "take": [place],
    "give": [place], "when": [fact], "unless": [fact]}]}. What is not a net is left out: the log may be anybody's.
    """
    found = []
    for net in nets:
        try:
            found.append(_drawing(net, shares))
        except (KeyError, TypeError, ValueError, AttributeError):
            continue
    return found


def _drawing(net: Mapping[str, Any], shares: Mapping[tuple[str, str], float]) -> Drawing:
    name, actions = str(net["name"]), dict(net["places"])
    row = {place: k for k, place in enumerate(actions)}
    sides: dict[int, list[tuple[float, int, Mapping[str, Any]]]] = {1: [], -1: []}
    for order, transition in enumerate(net["transitions"]):
        take, give = [row[p] for p in transition["take"]], [row[p] for p in transition["give"]]
        leads_on = sum(give) / max(len(give), 1) >= sum(take) / max(len(take), 1)
        at = sum((*take, *give)) / max(len(take) + len(give), 1)
        sides[1 if leads_on else -1].append((at, order, transition))
    rows = max((len(row) - 1) * PITCH, *((len(side) - 1) * SLOT for side in sides.values()), 0.0)
    pitch = rows / (len(row) - 1) if len(row) > 1 else 0.0
    y_of = {place: TOP + k * pitch for place, k in row.items()}
    bars = []
    for side, entries in sides.items():
        entries.sort(key=lambda entry: entry[:2])
        heights = _spread([TOP + at * pitch for at, _, _ in entries], TOP, TOP + rows)
        for (_, _, transition), y in zip(entries, heights, strict=True):
            bars.append(_bar(transition, side, y, y_of))
    places = tuple(
        Place(str(p), str(a), y_of[p], p in net["initial"], shares.get((name, str(p)))) for p, a in actions.items()
    )
    return Drawing(name, str(net.get("parent") or ""), WIDTH, 2.0 * TOP + rows, places, tuple(bars))


def _spread(wanted: list[float], low: float, high: float) -> list[float]:
    """Ascending heights [px] as near to the `wanted` ones as SLOT between them allows, within [low, high]."""
    out: list[float] = []
    for y in wanted:
        out.append(max(y, out[-1] + SLOT) if out else max(y, low))
    limit = high
    for i in range(len(out) - 1, -1, -1):
        out[i] = min(out[i], limit)
        limit = out[i] - SLOT
    return out


def _bar(transition: Mapping[str, Any], side: int, y: float, y_of: Mapping[str, float]) -> Bar:
    x = MIDDLE + side * BAR
    arcs = []
    for place in transition["take"]:
        arcs.append((_arc(MIDDLE + side * RADIUS, y_of[place], x - side * 3.0, y - 5.0, side), False))
    for place in transition["give"]:
        arcs.append((_arc(x - side * 3.0, y + 5.0, MIDDLE + side * (RADIUS + 4.0), y_of[place], side), True))
    words = [*(str(f) for f in transition.get("when", ())), *(f"not {f}" for f in transition.get("unless", ()))]
    guard = tuple(_lines(words))
    return Bar(str(transition["name"]), guard, x, y, x + side * 8.0, "start" if side > 0 else "end", tuple(arcs))


def _lines(words: Sequence[str]) -> list[str]:
    """Facts of a guard, joined by "and", in lines of GUARD_LETTERS."""
    lines: list[str] = []
    for word in (w.replace("_", " ") for w in words):
        if lines and len(lines[-1]) + 5 + len(word) <= GUARD_LETTERS:
            lines[-1] += f" and {word}"
        else:
            lines.append(f"and {word}" if lines else word)
    return lines


def _arc(x0: float, y0: float, x1: float, y1: float, side: int) -> str:
    """A curve that leaves and arrives level, so that no arc runs along the column of places."""
    bend = 0.55 * abs(x1 - x0)
    out, back = (side * bend, -side * bend) if abs(x1 - MIDDLE) > abs(x0 - MIDDLE) else (-side * bend, side * bend)
    return f"M{x0:.1f} {y0:.1f}C{x0 + out:.1f} {y0:.1f} {x1 + back:.1f} {y1:.1f} {x1:.1f} {y1:.1f}"
