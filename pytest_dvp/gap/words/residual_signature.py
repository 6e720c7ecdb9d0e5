"""The signature of an error that no effect explains, in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

STRONG = 0.3  # share of the error from which a rhythm or a place is worth a word
UNEVEN = 0.1  # share of the error beyond its share of the time


def signature_lines(signature: Mapping[str, Any]) -> list[tuple[str, str]]:
    """(aspect, words): what it looks like and what to examine; then for each axis what it follows, and when.

    `signature` as `pytest_dvp.gap.diagnose.residual_signature.signature` gives it; empty: no lines.
    """
    lines = [(title, str(signature[key])) for key, title in (("reading", "looks like"), ("look_at", "look at"))
             if signature.get(key)]  # fmt: skip
    for axis in signature.get("axes", ()):
        words = "; ".join([*_follows(axis), *_speed(axis), *_rhythm(axis), *_trend(axis)])
        if words:
            lines.append((str(axis["axis"]), words))
    return lines


def _follows(axis: Mapping[str, Any]) -> list[str]:
    terms = axis.get("regressors") or ()
    if not terms:
        return ["follows nothing that was tried"]
    names = ", then ".join(str(one["term"]) for one in terms)
    return [f"follows {names} ({_percent(terms[-1]['held_out_share'])} of it on segments left out)"]


def _speed(axis: Mapping[str, Any]) -> list[str]:
    one = axis.get("speed")
    if not one or one["share_of_error"] - one["share_of_time"] < UNEVEN:
        return []
    where = str(one["bin"]).removeprefix("speed ")
    return [f"{_percent(one['share_of_error'])} of it at {where}, {_percent(one['share_of_time'])} of the time"]


def _rhythm(axis: Mapping[str, Any]) -> list[str]:
    found = []
    for one in axis.get("rhythm") or ():
        if one and one["share"] >= STRONG:
            found.append(f"{_percent(one['share'])} of it repeats at {one['frequency']:.3g} {one['unit']}")
    return found


def _trend(axis: Mapping[str, Any]) -> list[str]:
    one = axis.get("trend")
    if not one or one["share_in_second_half"] < 0.5 + STRONG:
        return []
    return [f"{_percent(one['share_in_second_half'])} of it in the second half"]


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f} %"
