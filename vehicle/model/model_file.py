"""Vehicle model files (TOML): reading with errors that name file, line and key, and writing."""

from __future__ import annotations

import re
from collections.abc import Mapping
from math import isinf
from pathlib import Path
from typing import Any

from vehicle.model.car import CAR_DECLARATIONS, make_car
from vehicle.model.command_inputs import (
    FULL_CURRENT,
    FULL_PRESSURE,
    LONGITUDINAL,
    PEDAL_ACCELERATION,
    PEDAL_DECELERATION,
    Inputs,
    default_steer_scale,
)
from vehicle.model.effect import Effect
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.errors import ModelError, nearest_name
from vehicle.model.remainder import read_remainder, remainder_text
from vehicle.model.remainder_shape import channels_of, read_shape, shape_text
from vehicle.model.vehicle_model import BASES, AppliedEffect, Interval, VehicleModel, check_base
from vehicle.toml_file import TomlError, parse_toml, read_toml

__all__ = ["ModelError", "effect_text", "model_text", "parse_model", "read_model", "write_model"]

_INPUT_NUMBERS = (  # key, default, low, high, unit
    ("full_throttle", PEDAL_ACCELERATION, 0.0, 50.0, "m/s^2"),
    ("full_brake", PEDAL_DECELERATION, 0.0, 50.0, "m/s^2"),
    ("steer_scale", 1.0, -10.0, 10.0, "rad"),
    ("steer_zero", 0.0, -1.0, 1.0, "rad"),
    ("full_current", FULL_CURRENT, 0.0, 1e5, "A"),
    ("full_pressure", FULL_PRESSURE, 0.0, 1e9, "Pa"),
)
BLACK_BOXES = (".py", ".fmu", ".csv", ".mcap", ".mat", ".mf4", ".mdf", ".bag", ".db3")
_TABLES = ("model", "inputs", "parameters", "effect", "remainder")


class _Lines:
    """Finds the line of a key in the text of a TOML file."""

    def __init__(self, text: str) -> None:
        self.lines = text.splitlines()

    def find(self, table: str, key: str = "", nth: int = 0) -> int | None:
        """Line (from 1) of `key` in the nth table called `table`, else of the table's head, else None."""
        head = re.compile(rf"\s*\[{{1,2}}\s*{re.escape(table)}\s*\]{{1,2}}")
        any_head = re.compile(r"\s*\[")
        start = None
        for number, line in enumerate(self.lines, 1):
            if start is None:
                if head.match(line):
                    if nth == 0:
                        start = number
                        if not key:
                            return number
                    nth -= 1
            elif re.match(rf"\s*\[+[^\]]*\b{re.escape(key)}\s*\]", line) or re.match(
                rf"\s*[\"']?{re.escape(key)}[\"']?\s*[=.]", line
            ):
                return number
            elif any_head.match(line) and not re.match(rf"\s*\[{re.escape(table)}\.", line):
                break
        if start is None and not key:  # no table, though it should be one
            start = next(
                (n for n, line in enumerate(self.lines, 1) if re.match(rf"\s*{re.escape(table)}\s*=", line)), None
            )
        return start


def read_model(path: Path | str, *, extra: Mapping[str, Effect] | None = None) -> VehicleModel:
    """Read and check a vehicle model file; `extra` are effects of the user's own by name.

    Raises ModelError (one line: file, line, key, found, allowed, nearest name), also for a missing file.
    """
    path = Path(path)
    if not path.exists() and ".py:" not in path.name:
        raise ModelError("no such file", file=str(path))
    try:
        data, text = read_toml(path)
    except TomlError as error:
        if path.suffix.partition(":")[0] in BLACK_BOXES:
            only = "no model file (.toml): a Python function, an FMU or a second log can only be compared (dvp compare)"
            raise ModelError(only, file=str(path)) from error
        raise ModelError(str(error), file=str(path), line=error.line) from error
    return _model(data, text, str(path), extra)


def parse_model(text: str, file: str = "", *, extra: Mapping[str, Effect] | None = None) -> VehicleModel:
    """The model that the text of a model file describes. Raises ModelError."""
    try:
        data = parse_toml(text)
    except TomlError as error:
        raise ModelError(str(error), file=file, line=error.line) from error
    return _model(data, text, file, extra)


def _model(data: Mapping[str, Any], text: str, file: str, extra: Mapping[str, Effect] | None) -> VehicleModel:
    lines = _Lines(text)
    _known(data, _TABLES, file, "", lines)
    model = _table(data, "model", file, lines)
    _known(model, ("base", "name"), file, "model", lines)
    base = model.get("base", "kinematic_bicycle")
    if base not in BASES:
        raise ModelError(
            "unknown base",
            file=file,
            line=lines.find("model", "base"),
            key="model.base",
            found=repr(base),
            allowed=", ".join(BASES),
            nearest=nearest_name(str(base), BASES),
        )
    name = model.get("name", "")
    if not isinstance(name, str):
        line = lines.find("model", "name")
        raise ModelError("must be a text", file=file, line=line, key="model.name", found=repr(name))
    stated = _table(data, "inputs", file, lines)
    inputs = _inputs(stated, file, lines)
    parameters = _table(data, "parameters", file, lines)
    values = {key: _number(value, key, file, lines.find("parameters", key)) for key, value in parameters.items()}
    try:
        car = make_car(values)
    except ModelError as error:
        raise error.at(file, lines.find("parameters", error.key), f"parameters.{error.key}") from error
    effects: list[AppliedEffect] = []
    entries = data.get("effect", [])
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise ModelError("write [[effect]], one for each effect", file=file, line=lines.find("effect"), key="effect")
    for nth, entry in enumerate(entries):
        applied = _effect(entry, nth, base, file, lines, extra)
        if any(applied.name == other.name for other in effects):
            line = lines.find("effect", "name", nth)
            raise ModelError("effect stands twice", file=file, line=line, key="effect.name", found=applied.name)
        effects.append(applied)
    try:
        stated_remainder = _table(data, "remainder", file, lines)
        left = read_remainder(channels_of(stated_remainder))
        shape = read_shape(stated_remainder, extra)
    except ModelError as error:
        path = ["remainder", *error.key.split(".")]
        heads = range(
            len(path) - 1, 0, -1
        )  # [remainder.limits.jerk_limit] limit, or [remainder] limits.jerk_limit.limit
        found = (lines.find(".".join(path[:k]), ".".join(path[k:])) for k in heads)
        line = next((one for one in found if one), None)
        raise error.at(file, line, f"remainder.{error.key}") from error
    given = frozenset((*stated, *parameters))
    return VehicleModel(
        base=base,
        inputs=inputs,
        car=car,
        effects=tuple(effects),
        name=name,
        remainder=left,
        remainder_shape=shape,
        given=given,
    )


def _known(
    table: Mapping[str, Any], known: tuple[str, ...], file: str, where: str, lines: _Lines, nth: int = 0
) -> None:
    for key in table:
        if key not in known:
            raise ModelError(
                "unknown key",
                file=file,
                line=lines.find(where, key, nth) if where else lines.find(key),
                key=f"{where}.{key}" if where else key,
                found=key,
                allowed=", ".join(known),
                nearest=nearest_name(key, known),
            )


def _table(data: Mapping[str, Any], name: str, file: str, lines: _Lines) -> dict[str, Any]:
    table = data.get(name, {})
    if not isinstance(table, dict):
        raise ModelError(f"must be a table [{name}]", file=file, line=lines.find(name), key=name)
    return table


def _number(value: Any, key: str, file: str, line: int | None) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ModelError("must be a number", file=file, line=line, key=key, found=repr(value))
    return float(value)


def _inputs(table: Mapping[str, Any], file: str, lines: _Lines) -> Inputs:
    _known(table, ("steer", "longitudinal", *(key for key, *_ in _INPUT_NUMBERS)), file, "inputs", lines)
    steer = table.get("steer", "steer_cmd")
    if not isinstance(steer, str) or not steer.strip():
        line = lines.find("inputs", "steer")
        raise ModelError("must name a log column", file=file, line=line, key="inputs.steer", found=repr(steer))
    longitudinal = table.get("longitudinal", "accel_cmd")
    columns = tuple(part.strip() for part in str(longitudinal).split("+"))
    if " + ".join(columns) not in LONGITUDINAL:
        raise ModelError(
            "unknown longitudinal input",
            file=file,
            line=lines.find("inputs", "longitudinal"),
            key="inputs.longitudinal",
            found=repr(longitudinal),
            allowed=", ".join(LONGITUDINAL),
            nearest=nearest_name(str(longitudinal), LONGITUDINAL),
        )
    numbers = {}
    for key, default, low, high, unit in _INPUT_NUMBERS:
        line = lines.find("inputs", key)
        standard = default_steer_scale(steer) if key == "steer_scale" else default
        value = _number(table.get(key, standard), f"inputs.{key}", file, line)
        if not low <= value <= high or (value == low == 0.0):
            raise ModelError(
                "value not allowed",
                file=file,
                line=line,
                key=f"inputs.{key}",
                found=f"{value:g}",
                allowed=f"{'more than 0' if low == 0.0 else f'{low:g}'} to {high:g} {unit}",
            )
        numbers[key] = value
    return Inputs(steer=steer, longitudinal=columns, **numbers)


def _effect(
    entry: Mapping[str, Any], nth: int, base: str, file: str, lines: _Lines, extra: Mapping[str, Effect] | None
) -> AppliedEffect:
    _known(entry, ("name", "fitted_on", "parameters"), file, "effect", lines, nth)
    if "name" not in entry:
        raise ModelError("missing", file=file, line=lines.find("effect", "", nth), key="effect.name")
    try:
        found = find_effect(str(entry["name"]), extra)
        check_base(found, base)
    except ModelError as error:
        raise error.at(file, lines.find("effect", "name", nth), "effect.name") from error
    values: dict[str, float] = {}
    intervals: dict[str, Interval] = {}
    given = entry.get("parameters", {})
    if not isinstance(given, dict):
        raise ModelError("must be a table", file=file, line=lines.find("effect", "parameters", nth), key=found.name)
    for key, item in given.items():
        line = lines.find("effect", key, nth)
        where = f"{found.name}.{key}"
        try:
            declared = found.key(key)
            detail = item if isinstance(item, dict) else {"value": item}
            _known(detail, ("value", "low", "high", "unit"), file, where, lines)
            if "value" not in detail:
                raise ModelError("value missing")
            if detail.get("unit", declared.unit) != declared.unit:
                raise ModelError("wrong unit", found=repr(detail["unit"]), allowed=declared.unit)
            values[key] = declared.check(_number(detail["value"], where, file, line))
            if "low" in detail or "high" in detail:
                low = _number(detail.get("low", values[key]), where, file, line)
                high = _number(detail.get("high", values[key]), where, file, line)
                if not low <= values[key] <= high:
                    raise ModelError(
                        "value outside its interval", found=f"{values[key]:g}", allowed=f"{low:g}..{high:g}"
                    )
                intervals[key] = Interval(low, high)
        except ModelError as error:
            if error.file:
                raise
            raise error.at(file, line, where) from error
    fitted_on = entry.get("fitted_on", [])
    if not isinstance(fitted_on, list) or not all(isinstance(f, str) for f in fitted_on):
        line = lines.find("effect", "fitted_on", nth)
        raise ModelError("must be a list of texts", file=file, line=line, key=f"{found.name}.fitted_on")
    return AppliedEffect(found, found.complete(values), intervals, tuple(fitted_on))


def _toml_number(value: float) -> str:
    if isinf(value):
        return "inf" if value > 0 else "-inf"
    return repr(float(value))


def _toml_text(value: str) -> str:
    escaped = value.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(c if c.isprintable() else f"\\u{ord(c):04x}" for c in escaped) + '"'


def model_text(model: VehicleModel) -> str:
    """The model as the text of a model file, ordered: reading it gives the same model.

    Of a model that was read only what its file stated and what has changed since is written; defaults stay defaults.
    """
    values, given = model.car.values(), model.given
    if given is not None:
        values = _stated(values, given)
    units = {d.name: d.unit for d in CAR_DECLARATIONS}
    out = ["[model]", f'base = "{model.base}"']
    if model.name:
        out.append(f"name = {_toml_text(model.name)}")
    out += ["", "[inputs]", f"steer = {_toml_text(model.inputs.steer)}"]
    out.append(f"longitudinal = {_toml_text(' + '.join(model.inputs.longitudinal))}")
    always = ("full_throttle", "full_brake") if given is None else given
    for name, default, _low, _high, unit in _INPUT_NUMBERS:
        value = getattr(model.inputs, name)
        if name in always or value != (default_steer_scale(model.inputs.steer) if name == "steer_scale" else default):
            out.append(f"{name} = {_toml_number(value)}  # {unit}")
    out += ["", "[parameters]"]
    out += [f"{name} = {_toml_number(value)}  # {units[name]}" for name, value in values.items()]
    tables = ["\n".join(out), *(effect_text(applied) for applied in model.effects)]
    tables += [remainder_text(model.remainder), shape_text(model.remainder_shape)]
    return "\n\n".join(table.rstrip() for table in tables if table) + "\n"


def effect_text(applied: AppliedEffect) -> str:
    """The entry [[effect]] of a model file."""
    out = ["[[effect]]", f"name = {_toml_text(applied.name)}"]
    if applied.fitted_on:
        out.append(f"fitted_on = [{', '.join(_toml_text(f) for f in applied.fitted_on)}]")
    for key in applied.effect.parameters:
        out += [f"[effect.parameters.{key.name}]", f"value = {_toml_number(applied.values[key.name])}"]
        interval = applied.intervals.get(key.name)
        if interval:
            out += [f"low = {_toml_number(interval.low)}", f"high = {_toml_number(interval.high)}"]
        out.append(f"unit = {_toml_text(key.unit)}")
    return "\n".join(out) + "\n"


def _stated(values: Mapping[str, float], given: frozenset[str]) -> dict[str, float]:
    """Those parameters that were given, and those without which another car would be read."""
    kept = {name: value for name, value in values.items() if name in given}
    while True:  # defaults follow from other parameters: one more that is stated may change them
        try:
            read = make_car(kept).values()
        except ModelError:
            return dict(values)
        other = {name for name, value in values.items() if value != read[name]}
        if not other:
            return kept
        kept = {name: value for name, value in values.items() if name in kept or name in other}


def write_model(model: VehicleModel, path: Path | str, text: str | None = None) -> None:
    """Write a model file in one go: a reader never sees half of it. text: of edited_text; default: model_text."""
    path = Path(path)
    draft = path.with_name(path.name + ".part")
    draft.write_text(model_text(model) if text is None else text, encoding="utf-8")
    draft.replace(path)
