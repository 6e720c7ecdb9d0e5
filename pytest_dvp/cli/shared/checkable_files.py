"""Which files of a folder `dvp check` looks at, and what kind each one is."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

Kind = Literal["scenario", "road", "gates", "model", "study", "plan", "log", ""]

SKIPPED = frozenset({"node_modules", "runs", "__pycache__", "site-packages"})
"""Folders with files of others or of earlier runs; hidden ones and virtual environments are skipped as well."""

_KINDS: dict[str, Kind] = {".xosc": "scenario", ".xodr": "road"}
_TIME = re.compile(r"^\W*(t|time|timestamp)\b", re.IGNORECASE)
_COMMONROAD = re.compile(r"\ufeff?\s*(<\?.*?\?>|<!--.*?-->|\s)*<commonRoad\b", re.DOTALL)
_MODEL = re.compile(r"^\s*\[\s*model\s*\]", re.MULTILINE)
_GATE = re.compile(r"^\s*\[\[\s*gate\s*\]\]", re.MULTILINE)
_PLAN = re.compile(r"^\s*(\[\s*iterate\s*\]|\[\[\s*held_out\s*\]\])", re.MULTILINE)
_STUDY = re.compile(r"^\s*(\[\s*study\s*\]|\[\[\s*scenario\s*\]\])", re.MULTILINE)
_MOST = 1_000_000  # characters of a TOML file that are looked at


def files_of(folder: Path) -> list[Path]:
    """The files below `folder` that can be checked, in the order of their paths."""
    return sorted(path for path in _walk(folder) if kind_of(path))


def kind_of(path: Path) -> Kind:
    """What a file is by its name, and for .toml by its tables; "" for what is none of ours."""
    if path.suffix.lower() == ".xml":
        return "scenario" if _COMMONROAD.match(_head(path, 2000)) else ""
    if path.suffix.lower() != ".toml":
        return _KINDS.get(path.suffix.lower()) or _log(path)
    if path.name.endswith(".gates.toml"):
        return "gates"
    if path.name == "pyproject.toml":
        return ""
    text = _head(path, _MOST)
    if misnamed(path) or _GATE.search(text):
        return "gates"
    if _MODEL.search(text):
        return "model"
    return "plan" if _PLAN.search(text) else "study" if _STUDY.search(text) else ""


def _log(path: Path) -> Kind:
    """A log by its ending; where files of other kinds bear that as well, only if the first column is the time."""
    from pytest_dvp.logs.formats.log_format import log_formats

    ending = path.suffix.lower()
    for one in log_formats():
        if ending in one.endings and (ending not in one.common or _TIME.match(_head(path, 200))):
            return "log"
    return ""


def _head(path: Path, characters: int) -> str:
    try:
        with path.open(encoding="utf-8", errors="replace") as file:
            return file.read(characters)
    except OSError:
        return ""


def misnamed(path: Path) -> bool:
    """True for `mine.gate.toml` and the like, which a run does not find beside `mine.xosc`."""
    return re.search(r"[._-]gates?\.toml$", path.name, re.IGNORECASE) is not None and not path.name.endswith(
        ".gates.toml"
    )


def _walk(folder: Path) -> Iterator[Path]:
    for here, folders, names in os.walk(folder):
        folders[:] = [name for name in folders if not _is_skipped(Path(here, name))]
        yield from (path for name in names if not name.startswith(".") and (path := Path(here, name)).is_file())


def _is_skipped(folder: Path) -> bool:
    return folder.name.startswith(".") or folder.name in SKIPPED or (folder / "pyvenv.cfg").exists()
