"""Arguments that several commands share."""

from __future__ import annotations

import argparse
import os
from collections.abc import Collection, Iterable
from pathlib import Path

from pytest_dvp.drive.ini_file import NAMES, find_ini
from pytest_dvp.drive.option import LISTS, Setting
from pytest_dvp.drive.option_sources import environment_lookup, from_sources, misspelt_variable
from pytest_dvp.drive.run_spec import BUDGET, PLUGIN_SETTINGS, SETTINGS, RunSpec
from pytest_dvp.logs.budget import Budget
from pytest_dvp.text.errors import SettingError
from pytest_dvp.text.near_path import looked_for
from pytest_dvp.text.spelling import misspelt

ROOT_MARKS = (*NAMES, ".git")


class WrongArgument(ValueError):
    """A wrong option or a missing argument file: exit code 2."""


def add_settings(parser: argparse._ActionsContainer, names: Collection[str]) -> None:
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
    """Add the option `--json`, which every command that prints a result has."""
    parser.add_argument("--json", action="store_true", help="print one JSON document on stdout and nothing else")


def add_report(parser: argparse.ArgumentParser) -> None:
    """`--report` of the commands whose page has a name of its own: such a page is mailed, so it is one file always."""
    parser.add_argument("--report", metavar="FILE", help="write a page with figures, as one file that needs no other")
    parser.add_argument(
        "--single-file", action="store_true", help="as in dvp run; the page of --report is always one file"
    )


def settings_from(arguments: argparse.Namespace, ini: Collection[str] = ("library",)) -> RunSpec:
    """The options of a command: command line before environment before ini file.

    ini   names of those that count in the ini file: what may be read, and, where a command drives, all it has. The ini
          file is that of the folder in which the command stands: a scenario elsewhere brings no settings with it.

    Raises SettingError, also for a key or a variable that is nearly one of ours.
    """
    here, root = Path.cwd(), root_here()
    file = None if getattr(arguments, "no_ini", False) else find_ini(here)
    known = SETTINGS + PLUGIN_SETTINGS
    for wrong in (
        misspelt_variable(known),
        misspelt((name for name in (file.keys if file else ()) if name.startswith("dvp_")), [one.ini for one in known]),
    ):
        if wrong:
            raise SettingError(wrong)

    def given(setting: Setting) -> object:
        return getattr(arguments, setting.key, None)

    def in_file(setting: Setting) -> object:
        return None if file is None or setting.name not in ini else file.value(setting)

    sources = [
        (given, lambda setting: f"--{setting.name}", here),
        (environment_lookup(), lambda setting: f"environment {setting.environment}", here),
        (
            in_file,
            lambda setting: "" if file is None else file.origin(setting),
            here if file is None else file.file.parent,
        ),
    ]
    return from_sources(SETTINGS, sources, root)


def add_budget(parser: argparse.ArgumentParser) -> None:
    """The options of every command that reads a log: how large it may be."""
    add_settings(parser.add_argument_group("how large a log may be"), BUDGET)


def budget_from(arguments: argparse.Namespace) -> Budget:
    """How large the logs of a command may be: options before environment; of a run, the ini file after them.

    Raises SettingError.
    """
    here = Path.cwd()
    file = find_ini(here) if getattr(arguments, "no_ini", None) is False else None
    sources = [
        (lambda setting: getattr(arguments, setting.key, None), lambda setting: f"--{setting.name}", here),
        (environment_lookup(), lambda setting: f"environment {setting.environment}", here),
    ]
    if file is not None:
        sources.append((file.value, file.origin, file.file.parent))
    return from_sources([setting for setting in SETTINGS if setting.name in BUDGET], sources, here).budget


def root_here() -> Path:
    """The nearest folder from the current one upwards that has a configuration, as pytest finds its rootdir.

    A scenario elsewhere does not widen what may be read.
    """
    here = Path.cwd()
    for folder in (here, *here.parents):
        if any((folder / mark).exists() for mark in ROOT_MARKS):
            return folder
    return here


def new_file(option: str, text: str, read: Iterable[str | Path] = ()) -> Path:
    """A file that an option names to be written, asked before any work is done for it.

    read: files that the command reads, and does not write over.

    Raises WrongArgument if it is a folder or in none, cannot be written, or is one of those that are read.
    """
    if not text.strip():
        raise WrongArgument(f"{option}: no name, expected a file")
    path = Path(text)
    place = Path(os.path.realpath(path))  # of a link, what it points to
    try:
        if place.is_dir():
            raise WrongArgument(f"{option} {text}: a folder, expected a file")
        if not place.parent.is_dir():
            folder = path.parent if place == path.absolute() else place.parent
            raise WrongArgument(
                f"{option} {text}: {f'{folder} is no folder' if place.parent.exists() else f'no folder {folder}'}"
            )
        if not os.access(place if place.exists() else place.parent, os.W_OK):
            raise WrongArgument(f"{option} {text}: cannot be written: no permission")
        for other in read:
            if place.exists() and Path(other).exists() and place.samefile(other):
                raise WrongArgument(f"{option} {text} is a file that is read: name another")
    except OSError as error:
        raise WrongArgument(f"{option} {text}: {error.strerror}") from None
    return path


def existing(text: str, what: str) -> Path:
    """A file named as an argument. Raises WrongArgument if there is none."""
    path = Path(text)
    try:
        if not text.strip():
            raise WrongArgument(f"no name, expected a {what}")
        if not path.exists():
            raise WrongArgument(f"{text}: no such {what}{looked_for(path)}")
        if not path.is_file():
            raise WrongArgument(f"{text}: not a file, expected a {what}")
    except OSError as error:  # a name that is longer than names may be
        raise WrongArgument(f"{text}: {error.strerror}") from None
    return path
