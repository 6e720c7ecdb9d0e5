"""Arguments that several commands share."""

from __future__ import annotations

import argparse
import math
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from pytest_dvp.settings import LISTS, SETTINGS, Setting, Settings, environment_lookup, from_sources

ROOT_MARKS = ("pytest.ini", ".pytest.ini", "pyproject.toml", "tox.ini", "setup.cfg", ".git")


class WrongArgument(ValueError):
    """A wrong option or a missing argument file: exit code 2."""


def add_settings(parser: argparse.ArgumentParser, names: Collection[str]) -> None:
    """The options `--NAME` that are `--dvp-NAME` in pytest."""
    for setting in SETTINGS:
        if setting.name not in names:
            continue
        if setting.kind == "flag":
            parser.add_argument(f"--{setting.name}", action="store_true", default=None, help=setting.help)
        else:
            action = "append" if setting.kind in LISTS else "store"
            parser.add_argument(f"--{setting.name}", action=action, metavar=setting.metavar, help=setting.help)


def add_json(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="one JSON document on stdout and nothing else")


def settings_from(arguments: argparse.Namespace) -> Settings:
    """Settings of a command: command line before environment. Raises SettingError."""
    here = Path.cwd()

    def given(setting: Setting) -> object:
        return getattr(arguments, setting.key, None)

    sources = [
        (given, lambda setting: f"--{setting.name}", here),
        (environment_lookup(), lambda setting: f"environment {setting.environment}", here),
    ]
    return from_sources(SETTINGS, sources, root_here())


def root_here() -> Path:
    """The nearest folder from the current one upwards that has a configuration, as pytest finds its rootdir.

    A scenario elsewhere does not widen what may be read.
    """
    here = Path.cwd()
    for folder in (here, *here.parents):
        if any((folder / mark).exists() for mark in ROOT_MARKS):
            return folder
    return here


def existing(text: str, what: str) -> Path:
    """A file named as an argument. Raises WrongArgument if there is none."""
    path = Path(text)
    if not path.exists():
        raise WrongArgument(f"{text}: no such {what}")
    if not path.is_file():
        raise WrongArgument(f"{text}: not a file, expected a {what}")
    return path


def finite(value: Any) -> Any:
    """NaN and infinite as null, all the way down: a document is JSON."""
    if isinstance(value, Mapping):
        return {key: finite(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [finite(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
