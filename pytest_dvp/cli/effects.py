"""The catalogue of physical effects: equation, keys, unit, range, source."""

from __future__ import annotations

import argparse
import json
import math
import textwrap
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.cli.arguments import WrongArgument, add_json

if TYPE_CHECKING:
    from vehicle.model.effect import Effect, Key


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", nargs="?", metavar="NAME", help="one effect in full; default: a line for each")
    add_effects(parser)
    add_json(parser)


def add_effects(parser: argparse.ArgumentParser) -> None:
    """The option --effects, for every command that reads a vehicle model."""
    parser.add_argument(
        "--effects",
        action="append",
        default=[],
        metavar="FILE.py",
        help="effects of your own, written with @effect; the file is run: name only files that you trust",
    )


def effects_from(arguments: argparse.Namespace) -> dict[str, Effect]:
    """The effects of the files named by --effects, by name.

    Raises ModelError (one line naming the file) if a file is missing, fails, holds none, or takes a name that is taken.
    """
    from vehicle.model.catalogue import catalogue, effects_of_file
    from vehicle.model.errors import ModelError

    found: dict[str, Effect] = {}
    for text in arguments.effects:
        for name, effect in effects_of_file(Path(text)).items():
            if name in found or name in catalogue():
                raise ModelError("there is an effect of this name already", file=text, key=name)
            found[name] = effect
    return found


def execute(arguments: argparse.Namespace) -> int:
    from vehicle.model.catalogue import catalogue
    from vehicle.model.errors import nearest_name

    known = {**catalogue(), **effects_from(arguments)}
    name = arguments.name
    if name is not None and name not in known:
        near = nearest_name(name, known)
        hint = f", did you mean {near!r}?" if near else ""
        raise WrongArgument(f"dvp effects: no effect called {name!r}{hint} (dvp effects lists them)")
    chosen = [known[name]] if name is not None else [known[key] for key in sorted(known)]
    if arguments.json:
        print(json.dumps({"effects": [as_dict(effect) for effect in chosen]}, ensure_ascii=False))
    elif name is not None:
        print(_page(chosen[0]))
    else:
        _table(chosen)
    return 0


def as_dict(effect: Effect) -> dict[str, Any]:
    """What is known of an effect, JSON-able; a limit that is infinite is null."""
    return {
        "name": effect.name,
        "slot": effect.slot,
        "physics": effect.physics,
        "equation": effect.equation,
        "source": effect.source,
        "parameters": {k.name: _key(k) for k in effect.parameters},
        "ties": list(effect.ties),
        "reveals": effect.reveals,
        "tyres": effect.tyres,
    }


def _key(key: Key) -> dict[str, Any]:
    numbers: Mapping[str, float] = {
        "low": key.low,
        "high": key.high,
        "neutral": key.neutral,
        "least": key.least,
        "minimum": key.minimum,
        "maximum": key.maximum,
    }
    finite = {name: value if math.isfinite(value) else None for name, value in numbers.items()}
    return {"unit": key.unit, "meaning": key.meaning, **finite}


def _table(effects: list[Effect]) -> None:
    width = max(len(effect.name) for effect in effects)
    for effect in effects:
        keys = ", ".join(f"{k.name} {k.low:g}..{k.high:g} {k.unit}" for k in effect.parameters)
        print(f"{effect.name:{width}}  {effect.slot:10}  {effect.equation}  [{keys}]")


def _page(effect: Effect) -> str:
    lines = [
        effect.name,
        *textwrap.wrap(effect.physics, 100, initial_indent="  ", subsequent_indent="  "),
        f"  equation   {effect.equation}",
        f"  acts on    {effect.slot}" + (" (a kinematic car gets tyres by it)" if effect.tyres else ""),
        f"  source     {effect.source}",
    ]
    for k in effect.parameters:
        off = f"{k.neutral:g} switches it off, {k.least:g} is the least worth naming"
        lines.append(f"  {k.name:10} {k.low:g} to {k.high:g} {k.unit}: {k.meaning}; {off}")
    if effect.ties:
        lines.append(f"  like it    {', '.join(effect.ties)}")
    lines.append(f"  to see it  {effect.reveals}")
    return "\n".join(lines)
