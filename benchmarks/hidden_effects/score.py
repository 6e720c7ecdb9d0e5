"""Answers against the truth: what the table of figures is made of. Works on the lines of a run, nothing else."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from scipy.stats import beta

from benchmarks.hidden_effects.case import HARMLESS
from benchmarks.hidden_effects.ranges import neutral

Line = Mapping[str, Any]
SEEN = 1.05  # chi^2/N before, from which on "excess error removed" means something


@dataclass(frozen=True)
class Share:
    """`hits` of `count`; undefined (None) without cases. low, high: one-sided 95 % bounds of the rate behind it.

    Source of the bounds: Clopper and Pearson, Biometrika 26 (1934) 404.
    """

    hits: int
    count: int

    @property
    def value(self) -> float | None:
        """The share, 0..1."""
        return self.hits / self.count if self.count else None

    @property
    def low(self) -> float:
        """The rate is higher than this with 95 % confidence; 0 without cases."""
        return float(beta.ppf(0.05, self.hits, self.count - self.hits + 1)) if self.hits else 0.0

    @property
    def high(self) -> float:
        """The rate is lower than this with 95 % confidence; 1 without cases."""
        return float(beta.ppf(0.95, self.hits + 1, self.count - self.hits)) if self.hits < self.count else 1.0


@dataclass(frozen=True)
class ParameterError:
    """|estimate - truth| over the size of the effect (truth - neutral) and over the value; in the interval or not."""

    of_effect: float
    of_value: float
    covered: bool | None


def asked(lines: Iterable[Line], *categories: str) -> list[Line]:
    """Lines of these categories whose effects can be seen."""
    return [line for line in lines if line["category"] in categories and line["verdict"] != "UNDETECTABLE"]


def names(line: Line) -> list[str]:
    """Effects named, in the order of the answer."""
    return [effect["name"] for effect in line["effects"]]


def returned(effect: Mapping[str, Any]) -> set[str]:
    """The returned set of an effect: its name and its rivals."""
    return {effect["name"], *effect.get("rivals", ())}


def share(lines: Sequence[Line], holds: Callable[[Line], bool]) -> Share:
    """How many of the lines it holds for."""
    return Share(sum(1 for line in lines if holds(line)), len(lines))


def first_is_true(line: Line) -> bool:
    """Named first: an effect that is there."""
    return bool(names(line)) and names(line)[0] in line["truth"]


def first_two_hold_it(line: Line) -> bool:
    """Among the first two named."""
    return bool(set(names(line)[:2]) & set(line["truth"]))


def set_holds_truth(line: Line) -> bool:
    """Every hidden effect is in the set of some effect of the answer."""
    inside = set().union(*(returned(effect) for effect in line["effects"])) if line["effects"] else set()
    return set(line["truth"]) <= inside


def exact(line: Line) -> bool:
    """Just the hidden effects are named."""
    return set(names(line)) == set(line["truth"])


def all_found(line: Line) -> bool:
    """All hidden effects are named, whatever else is."""
    return set(line["truth"]) <= set(names(line))


def set_size(lines: Sequence[Line]) -> float | None:
    """Mean size of the set of the first effect, over the answers that have one."""
    sizes = [len(returned(line["effects"][0])) for line in lines if line["effects"]]
    return sum(sizes) / len(sizes) if sizes else None


def confident_and_wrong(line: Line) -> bool:
    """NAMED, one effect without a rival, and it is not there."""
    if line["verdict"] != "NAMED" or len(line["effects"]) != 1:
        return False
    return len(returned(line["effects"][0])) == 1 and names(line)[0] not in line["truth"]


def confirmed(line: Line) -> list[str]:
    """Names that the answer calls confirmed, under whatever verdict; of a record without standings those without rivals
    under NAMED."""
    return [
        effect["name"] for effect in line["effects"]
        if effect.get("standing", "confirmed" if line["verdict"] == "NAMED" and not effect.get("rivals") else "")
        == "confirmed"
    ]  # fmt: skip


def wrongly_confirmed(lines: Iterable[Line]) -> Share:
    """Of all confirmed names those that are not hidden in their car."""
    found = [name in line["truth"] for line in lines for name in confirmed(line)]
    return Share(found.count(False), len(found))


def confirmed_and_true(line: Line) -> bool:
    """All hidden effects are confirmed."""
    return set(line["truth"]) <= set(confirmed(line))


def names_too_much(line: Line) -> bool:
    """Says, without a rival that is there, that something is missing which is not."""
    return any(not returned(effect) & set(line["truth"]) for effect in line["effects"])


def flagged(line: Line) -> bool:
    """PARTIAL or UNKNOWN."""
    return line["verdict"] in ("PARTIAL", "UNKNOWN")


def refused(line: Line) -> bool:
    """The doctor found an error in the log, or the diagnosis told that its data cannot be used."""
    return line["verdict"] == "REFUSED"


def dirt_is_survived(line: Line) -> bool:
    """Harmless dirt: named first all the same."""
    return line["dirt"] in HARMLESS and first_is_true(line)


def no_wrong_name(line: Line) -> bool:
    """A wrong column: refused, flagged, or nothing named that is not there."""
    return refused(line) or flagged(line) or not names_too_much(line)


def disappears(line: Line) -> bool:
    """Ablation: the effect that was switched off is not named."""
    return line["verdict"] not in ("ERROR", "REFUSED") and line["off"] not in names(line)


def _of_the_bare_car(lines: Sequence[Line]) -> dict[tuple[str, str], set[str]]:
    """What the independent truths are said to have with nothing hidden in them, by category and car."""
    own: dict[tuple[str, str], set[str]] = {}
    for line in lines:
        if not line["names"]:
            own.setdefault((line["category"], line["car"]), set()).update(names(line))
    return own


def not_named_without(lines: Sequence[Line]) -> Share:
    """Of the effects found on top of an independent truth, those that the same car without them is not said to have."""
    own = _of_the_bare_car(lines)
    found = [
        (name, own[line["category"], line["car"]])
        for line in lines
        if line["names"] and (line["category"], line["car"]) in own
        for name in names(line)
        if name in line["truth"]
    ]
    return Share(sum(1 for name, others in found if name not in others), len(found))


def first_two_new_hold_it(lines: Sequence[Line]) -> Share:
    """On an independent truth, among the first two names that the bare car is not said to have."""
    own = _of_the_bare_car(lines)
    hidden = [line for line in lines if line["names"] and (line["category"], line["car"]) in own]
    hits = 0
    for line in hidden:
        new = [name for name in names(line) if name not in own[line["category"], line["car"]] - set(line["truth"])]
        hits += bool(set(new[:2]) & set(line["truth"]))
    return Share(hits, len(hidden))


def parameter_errors(line: Line) -> Iterator[ParameterError]:
    """Errors of every parameter of every hidden effect that was named."""
    for effect in line["effects"]:
        if effect["name"] in line["truth"]:
            true, found = line["truth"][effect["name"]], effect["parameters"]
            if {"slope", "heading"} <= set(true):
                yield _slope_error(true, found)
            elif {"x", "y"} <= set(true):
                yield _vector_error(true, found)
            else:
                yield from (_error(effect["name"], key, value, found[key]) for key, value in true.items())


def _inside(value: float, found: Mapping[str, Any]) -> bool | None:
    low, high = found.get("low"), found.get("high")
    if low is None or high is None:
        return None
    return bool(low <= value <= high)


def _error(name: str, key: str, true: float, found: Mapping[str, Any]) -> ParameterError:
    off = neutral(name, key)
    size = abs(true) if math.isinf(off) else abs(true - off)
    apart = abs(found["value"] - true)
    return ParameterError(apart / max(size, 1e-9), apart / max(abs(true), 1e-9), _inside(true, found))


def _slope_error(true: Mapping[str, float], found: Mapping[str, Any]) -> ParameterError:
    """A slope along a heading is a vector; and s along h is -s along h + pi."""
    s, h = found["slope"]["value"], found["heading"]["value"]
    x, y = true["slope"] * math.cos(true["heading"]), true["slope"] * math.sin(true["heading"])
    apart = math.hypot(s * math.cos(h) - x, s * math.sin(h) - y) / max(abs(true["slope"]), 1e-9)
    side = 1.0 if s * true["slope"] > 0.0 else -1.0
    return ParameterError(apart, apart, _inside(side * true["slope"], found["slope"]))


def _vector_error(true: Mapping[str, float], found: Mapping[str, Any]) -> ParameterError:
    apart = math.hypot(*(found[key]["value"] - true[key] for key in ("x", "y")))
    apart /= max(math.hypot(true["x"], true["y"]), 1e-9)
    return ParameterError(apart, apart, _inside(true["x"], found["x"]))


def chi2(line: Line, run: str, when: str) -> float | None:
    """chi^2/N that the answer tells: run "fit" or "held_out", "before" or "after" the named effects."""
    value = ((line.get("chi2_per_n") or {}).get(run) or {}).get(when)
    return None if value is None else float(value)


def excess_removed(line: Line) -> float | None:
    """Share of the held-out error above the noise floor that the named effects took away; < 0 is a loss."""
    before, after = chi2(line, "held_out", "before"), chi2(line, "held_out", "after")
    if before is None or after is None or before < SEEN:
        return None
    return 1.0 - max(after - 1.0, 0.0) / (before - 1.0)


def quantile(values: Iterable[float | None], q: float) -> float | None:
    """Quantile by rank, straight between ranks; None without values."""
    found = sorted(value for value in values if value is not None)
    if not found:
        return None
    place = q * (len(found) - 1)
    low = math.floor(place)
    high = min(low + 1, len(found) - 1)
    return found[low] + (place - low) * (found[high] - found[low])
