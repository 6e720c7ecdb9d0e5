"""Lists the catalogue of physical effects, with equation, keys, unit, range and source."""

from __future__ import annotations

import argparse
import json
import math
import textwrap
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.cli.shared.arguments import WrongArgument, add_json, existing

if TYPE_CHECKING:
    from vehicle.model.effect import Effect, Key

PLACE = 160  # in `dvp --help`
READS_NO_LOG = True


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the name of an effect, files of own effects, and the switch that lists the fields of the bus."""
    parser.add_argument(
        "name", nargs="?", metavar="NAME", help="effect to describe in full; default: one line for each effect"
    )
    parser.add_argument(
        "--fields",
        action="store_true",
        help="list the fields that your effect may read and change, with unit and meaning",
    )
    add_effects(parser)
    add_json(parser)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = _epilog()


def _epilog() -> str:
    """The names of the bus fields by slot."""
    from vehicle.model.bus import bus_table

    lines = ["fields of the bus x of an effect of your own (--fields: unit and meaning of each):"]
    for title, fields in bus_table().items():
        names = ", ".join(f.name for f in fields)
        lines += [f"  {title}:", *textwrap.wrap(names, 100, initial_indent="    ", subsequent_indent="    ")]
    lines += textwrap.wrap(
        "A key's low..high is met in practice (a search looks there, a model may hold a value outside); outside "
        "minimum..maximum a value is refused.",
        100,
    )
    return "\n".join(lines)


def add_effects(parser: argparse.ArgumentParser) -> None:
    """The option --effects, for every command that reads a vehicle model."""
    parser.add_argument(
        "--effects",
        action="append",
        default=[],
        metavar="FILE.py",
        help="file with your effects, written with @effect; it is executed, so name only files that you trust",
    )


def effects_from(arguments: argparse.Namespace) -> dict[str, Effect]:
    """The effects of the files named by --effects, by name.

    Raises WrongArgument for a missing file, ModelError (one line naming it) for one that fails, holds none, or takes a
    name that is taken.
    """
    from vehicle.model.effect_catalogue import effects_of_files

    for text in arguments.effects:
        existing(text, "file of effects")
    return effects_of_files(Path(text) for text in arguments.effects)


def execute(arguments: argparse.Namespace) -> int:
    """Print one effect or all. Returns 0; raises WrongArgument with the nearest name for an unknown one."""
    from vehicle.model.effect_catalogue import catalogue
    from vehicle.model.errors import nearest_name

    if arguments.fields:
        _print_fields(as_json=arguments.json)
        return 0
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


def _print_fields(*, as_json: bool) -> None:
    from vehicle.model.bus import bus_table

    groups = bus_table()
    if as_json:
        print(json.dumps({"fields": [{"group": title, **f._asdict()} for title, fs in groups.items() for f in fs]}))
        return
    for title, fields in groups.items():
        print(title)
        for f in fields:
            print(f"  x.{f.name:18} {f.unit:8} {f.meaning}")


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
        lines.append(f"  {k.name:10} {k.low:g} to {k.high:g} {k.unit}: {k.meaning}; {off}; allowed: {k.allowed}")
    if effect.ties:
        lines.append(f"  like it    {', '.join(effect.ties)}")
    lines.append(f"  to see it  {effect.reveals}")
    return "\n".join(lines)
