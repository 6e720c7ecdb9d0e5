"""docs/diagnose.md: its commands are commands, its model file is one, and it explains every verdict."""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from typing import get_args

import pytest

from pytest_dvp.cli.dispatch import build_parser
from pytest_dvp.drive.run_spec import PLUGIN_SETTINGS
from pytest_dvp.gap.diagnose.diagnosis import Verdict
from vehicle.model.effect_catalogue import catalogue
from vehicle.model.model_file import parse_model

PAGE = (Path(__file__).parents[3] / "docs" / "diagnose.md").read_text(encoding="utf-8")
COMMANDS = re.findall(
    r"^(?:    |\$ |.*add it: )dvp ((?:doctor|diagnose|extend|compare) .*?)(?: {2,}#.*)?$", PAGE, re.MULTILINE
)


def test_the_way_is_shorter_than_ten_commands() -> None:
    first = re.search(r"(?:^    \S.*\n)+", PAGE, re.MULTILINE)
    assert first is not None
    assert 4 <= len(first[0].splitlines()) < 10


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_is_one(command: str) -> None:
    arguments = build_parser().parse_args(shlex.split(command))
    for name in [*getattr(arguments, "add", [])]:
        assert name in catalogue()


def test_there_are_commands_to_test() -> None:
    assert {command.split()[0] for command in COMMANDS} == {"doctor", "diagnose", "extend", "compare"}


def test_model_file_is_read_as_printed() -> None:
    text = re.search(r"^```toml\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    assert text is not None
    assert parse_model(text[1]).car.wheelbase == 2.45


@pytest.mark.parametrize("verdict", get_args(Verdict))
def test_every_verdict_is_explained(verdict: str) -> None:
    assert f"\n| `{verdict}` |" in PAGE


def test_switch_is_called_as_printed() -> None:
    switch = next(setting for setting in PLUGIN_SETTINGS if setting.name == "no-diagnosis")
    for name in (f"--dvp-{switch.name}", f"{switch.ini} = true", f"{switch.environment}=1"):
        assert f"`{name}`" in PAGE
