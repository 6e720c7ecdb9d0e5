"""A value of each option that RunSpec declares, as a user writes it."""

from __future__ import annotations

import argparse
from pathlib import Path

from pytest_dvp.cli.run import add_arguments
from pytest_dvp.cli.shared.arguments import settings_from
from pytest_dvp.drive.option import Setting
from pytest_dvp.drive.run_spec import OPTIONS, PLUGIN_SETTINGS, SETTINGS, RunSpec

OF_ONE = {"shard": "1/2", "campaign-method": "random"}  # that are checked as soon as they are read
OF_A_RUN = [setting for setting in OPTIONS if setting.home == "run"]


def texts_of(place: Path) -> dict[str, str]:
    """A value of each option as a user writes it, none of which is the default."""
    (place / "folder").mkdir()
    (place / "file").write_text("")
    return {setting.name: _text(setting, place) for setting in (*SETTINGS, *PLUGIN_SETTINGS)}


def _text(setting: Setting, place: Path) -> str:
    if setting.name in OF_ONE:
        return OF_ONE[setting.name]
    if setting.choices:
        return next(choice for choice in setting.choices if choice != setting.default)
    by_kind: dict[str, str] = {
        "int": "3",
        "float": "2.5",
        "size": "2GB",
        "str": "can",
        "flag": "true",
        "ads": "module:Class",
        "delay": "0.2+-0.1",
        "assignments": "a=1",
        **dict.fromkeys(("path", "new_file"), str(place / "new")),
        "paths": str(place / "folder"),
        **dict.fromkeys(("file", "files", "logs"), str(place / "file")),
    }
    return by_kind[setting.kind]


def words(texts: dict[str, str], prefix: str) -> list[str]:
    flags = {setting.name for setting in OPTIONS if setting.kind == "flag"}
    return [f"{prefix}{name}" if name in flags else f"{prefix}{name}={value}" for name, value in texts.items()]


def changed(spec: RunSpec) -> set[str]:
    """The options that are not at their default."""
    usual = RunSpec()
    return {setting.name for setting in OPTIONS if getattr(spec, setting.key) != getattr(usual, setting.key)} - {
        "rootdir"
    }


def dvp_run(arguments: list[str]) -> RunSpec:
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    return settings_from(parser.parse_args(["x.xosc", *arguments]))
