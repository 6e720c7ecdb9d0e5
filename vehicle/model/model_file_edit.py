"""A vehicle model file changed to say another model: what did not change stays as it was written, with its comments."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, MutableMapping
from typing import Any

from vehicle.model.effect import Effect
from vehicle.model.errors import ModelError
from vehicle.model.model_file import effect_text, model_text, parse_model
from vehicle.model.remainder import remainder_text
from vehicle.model.remainder_shape import shape_text
from vehicle.model.vehicle_model import AppliedEffect, VehicleModel

_HEAD = re.compile(r"\s*\[\[\s*effect\s*\]\]")
_OTHER_HEAD = re.compile(r"\s*\[(?!\s*effect\s*\.)")


def edited_text(text: str, model: VehicleModel, *, extra: Mapping[str, Effect] | None = None) -> str | None:
    """The model file `text` changed so that it says `model`; comments and order stay, a comment beside a changed number
    says which it was.

    None where the file is written in a way that this cannot change; `extra` as of read_model. Raises ModelError if
    `text` is no model file.
    """
    import tomlkit
    from tomlkit.exceptions import TOMLKitError

    given = parse_model(text, extra=extra)
    old = {applied.name: applied for applied in given.effects}
    new = {applied.name: applied for applied in model.effects}
    try:
        document: Any = tomlkit.parse(text)
        said = tomllib.loads(model_text(model))
        for table in ("inputs", "parameters"):
            _values(document, table, said[table])
        for nth, name in enumerate(old):
            if name in new and new[name] != old[name]:
                _effect(document["effect"][nth], new[name])
        other_remainder = (model.remainder, model.remainder_shape) != (given.remainder, given.remainder_shape)
        if other_remainder and "remainder" in document:
            del document["remainder"]
        changed = tomlkit.dumps(document)
    except (TOMLKitError, LookupError, TypeError, ValueError):
        return None
    for nth, name in reversed(list(enumerate(old))):
        if name not in new:
            changed = _without(changed, nth)
    for name, applied in new.items():
        if name not in old:
            changed = f"{changed.rstrip()}\n\n{effect_text(applied)}"
    if other_remainder:
        said_again = f"{remainder_text(model.remainder)}\n{shape_text(model.remainder_shape)}"
        changed = f"{_without_comment(changed).rstrip()}\n\n{said_again}".rstrip() + "\n"
    try:
        return changed if parse_model(changed, extra=extra) == model else None
    except ModelError:
        return None


def _without_comment(text: str) -> str:
    """Without the comment that stood above a table [remainder] which was taken out."""
    head = remainder_text({"v": {"cruise": 0.0}}).splitlines()[0]
    return "\n".join(line for line in text.splitlines() if line != head) + "\n"


def _values(document: MutableMapping[str, Any], name: str, said: Mapping[str, Any]) -> None:
    """Numbers that differ or are new; a text ([inputs] steer) never changes, and stays unstated where it was."""
    for key, value in said.items():
        if isinstance(value, float) and (key not in document.get(name, {}) or document[name][key] != value):
            _put(document.setdefault(name, {}), key, value)


def _effect(table: MutableMapping[str, Any], applied: AppliedEffect) -> None:
    """New values, intervals and provenance of an effect that the file has."""
    if applied.fitted_on:
        table["fitted_on"] = list(applied.fitted_on)
    elif "fitted_on" in table:
        del table["fitted_on"]
    given = table.setdefault("parameters", {})
    for key in applied.effect.parameters:
        value, interval = applied.values[key.name], applied.intervals.get(key.name)
        if key.name not in given and value == applied.effect.complete({})[key.name] and interval is None:
            continue
        if not isinstance(given.get(key.name, {}), Mapping):  # `T = 0.2`
            if interval is None:
                _put(given, key.name, value)
                continue
            given[key.name] = {"value": given[key.name]}
        entry = given.setdefault(key.name, {})
        if entry.get("value") != value:
            _put(entry, "value", value)
        for side in ("low", "high"):
            if interval is not None:
                entry[side] = getattr(interval, side)
            elif side in entry:
                del entry[side]
        entry.setdefault("unit", key.unit)


def _put(table: MutableMapping[str, Any], key: str, value: float) -> None:
    """A number; a comment beside the one before is about that one, so it says which it was."""
    import tomlkit

    before = table.get(key)
    table[key] = value
    comment = before.trivia.comment if before is not None else ""
    if comment:
        table.item(key).comment(f"{comment.lstrip('# ')}; was {tomlkit.item(before).as_string()}")  # type: ignore[attr-defined]


def _without(text: str, nth: int) -> str:
    """Without the nth [[effect]] and the comment right above it; what stands right above the next head is its own."""
    lines = text.splitlines(keepends=True)
    start = [k for k, line in enumerate(lines) if _HEAD.match(line)][nth]
    end = next((k for k in range(start + 1, len(lines)) if _OTHER_HEAD.match(lines[k])), len(lines))
    if end < len(lines):
        end = _above(lines, end)
    return "".join([*lines[: _above(lines, start)], *lines[end:]])


def _above(lines: list[str], head: int) -> int:
    """The first line of the comment right above a head."""
    while head and lines[head - 1].lstrip().startswith("#"):
        head -= 1
    return head
