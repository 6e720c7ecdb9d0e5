"""The scenarios that a command line names: files, and those of the folders."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pytest_dvp.cli.shared.arguments import WrongArgument, existing
from pytest_dvp.cli.shared.checkable_files import files_of, kind_of
from pytest_dvp.cli.shared.runnable_scenarios import is_catalogue


def named_scenarios(texts: Sequence[str]) -> list[Path]:
    """The files in the order of the arguments, those of a folder in the order of their paths.

    A folder stands for the scenarios and parameter distributions in it and below, catalogues left out, as for
    `dvp check` and pytest; one that is named already is not driven twice for it. Raises WrongArgument for a path that
    leads nowhere, and for a folder without a scenario.
    """
    named: list[Path] = []
    for text in texts:
        if not text.strip() or not Path(text).is_dir():
            named.append(existing(text, "scenario"))
            continue
        found = [path for path in files_of(Path(text)) if kind_of(path) == "scenario" and not is_catalogue(path)]
        if not found:
            raise WrongArgument(f"{text}: no scenario in this folder or below it, expected .xosc files")
        others = {path.resolve() for path in named}
        named += [path for path in found if path.resolve() not in others]
    return named
