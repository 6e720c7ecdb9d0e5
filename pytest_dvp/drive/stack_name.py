"""Names of driving stacks: entry points, classes, files; checked without loading any."""

from __future__ import annotations

from importlib.metadata import EntryPoint, entry_points
from pathlib import Path

from pytest_dvp.text.errors import SettingError
from pytest_dvp.text.names import REFERENCE
from pytest_dvp.text.near_path import looked_for
from pytest_dvp.text.spelling import unknown

ENTRY_POINTS = "pytest_dvp.ads"
REMOTE = "ros2:"


def check_name(text: str, origin: str, base: Path) -> str:
    """A name as a setting gives it, files made absolute; loads nothing. Raises SettingError with the nearest name."""
    file, colon, name = text.rpartition(":")
    if text.startswith(REMOTE):
        path = (base / text.removeprefix(REMOTE)).absolute()
        if not path.is_file():
            raise SettingError(f"{origin}: no file {path}{looked_for(path)}")
        return f"{REMOTE}{path}"
    if text.endswith(".py"):
        raise SettingError(f"{origin}: {text} is a file; name the class in it, as in {text}:Stack")
    if colon and file.endswith(".py"):
        path = (base / file).absolute()
        if not path.is_file():
            raise SettingError(f"{origin}: no file {path}{looked_for(path)}")
        return f"{path}:{name}"
    if not colon:
        names = [REFERENCE, *stack_entry_points()]
        if text not in names:
            raise SettingError(f"{origin}: {unknown('ADS', text, names)}; or name module:Class or file.py:Class")
    return text


def stack_entry_points() -> dict[str, EntryPoint]:
    """The stacks that installed packages offer, by name; of two with one name the last by value."""
    return {point.name: point for point in sorted(entry_points(group=ENTRY_POINTS), key=lambda p: (p.name, p.value))}
