"""Values of the options: from the command line, the environment and the ini file, each text turned into its value.

Imports the standard library only: the pytest plugin reads it at start-up.
"""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from pytest_dvp.drive.assignments import parse_assignments
from pytest_dvp.drive.option import Setting
from pytest_dvp.drive.run_spec import RunSpec
from pytest_dvp.logs.budget import parse_size
from pytest_dvp.logs.unfinished_run import told_of
from pytest_dvp.text.errors import SettingError
from pytest_dvp.text.flags import is_on
from pytest_dvp.text.names import REFERENCE
from pytest_dvp.text.spelling import misspelt, unknown

TABLE = {"gates": "gate", "stage_gates": "gate", "model": "model"}
"""Options that name a TOML file, and the table by which such a file is known: only such a file is suggested."""
_NO_SETTINGS = ("DVP_SHARED",)  # where our own tests look for material beside the checkout: nearly DVP_SHARD


def convert(setting: Setting, raw: object, origin: str, base: Path) -> Any:
    """Value of a setting from its text. `base` is the folder relative paths start from.

    Raises SettingError naming `origin`, what was found and what is allowed.
    """
    if setting.kind == "assignments":
        words = [raw] if isinstance(raw, str) else list(raw)  # type: ignore[call-overload]
        return parse_assignments([str(word) for word in words], origin)
    if setting.kind == "paths":
        return tuple(_folder(base / str(word), origin) for word in raw)  # type: ignore[attr-defined]
    if setting.kind == "files":
        return tuple(_file(base / str(word), origin) for word in raw)  # type: ignore[attr-defined]
    if setting.kind == "logs":
        return tuple(_log(base / str(word), origin) for word in raw)  # type: ignore[attr-defined]
    text = str(raw).strip()
    if setting.kind == "flag":
        return raw if isinstance(raw, bool) else is_on(text, origin)
    if setting.kind in ("int", "float"):
        return _number(setting, text, origin)
    if setting.kind == "size":
        try:
            return parse_size(text)
        except ValueError as error:
            raise SettingError(f"{origin} is {text!r}, expected {error}") from None
    if setting.kind == "path":
        return possible_folder(base / text, origin)
    if setting.kind == "file":
        return _file(base / text, origin, TABLE.get(setting.key, ""))
    if setting.kind == "new_file":
        return _new_file(base / text, origin)
    if setting.kind == "ads" and text != REFERENCE:
        from pytest_dvp.drive.stack_name import check_name

        return check_name(text, origin, base)
    if setting.kind == "delay":
        from pytest_dvp.drive.compute_delay import parse_delay

        return str(parse_delay(text, origin))
    if setting.choices and text not in setting.choices:
        raise SettingError(f"{origin}: {unknown(setting.name, text, setting.choices)}")
    return text


def from_sources(
    settings: Iterable[Setting],
    sources: Sequence[tuple[Callable[[Setting], object], Callable[[Setting], str], Path]],
    rootdir: Path,
) -> RunSpec:
    """Settings of the first source that has a value; each source is (lookup, name for messages, base of paths).

    Empty in an ini file or the environment is not set. An option that was written and is empty is a mistake: a variable
    of a script that has no value must not be a run without its gates. Raises SettingError.
    """
    values: dict[str, Any] = {}
    origins: dict[str, str] = {}
    for setting in settings:
        for lookup, name, base in sources:
            raw = lookup(setting)
            if name(setting).startswith("--") and (raw == "" or (isinstance(raw, list | tuple) and "" in raw)):
                raise SettingError(f"{name(setting)} is empty, expected {setting.metavar or 'a value'}")
            if raw is not None and raw != "" and raw != []:
                values[setting.key] = convert(setting, raw, name(setting), base)
                origins[setting.key] = name(setting)
                break
    return RunSpec(rootdir=rootdir, origins=origins, **values)


def environment_lookup(environ: Mapping[str, str] = os.environ) -> Callable[[Setting], object]:
    """Lookup of a setting in the environment; lists are separated like PATH, assignments by spaces."""

    def lookup(setting: Setting) -> object:
        text = environ.get(setting.environment)
        if not text:
            return None
        if setting.kind in ("paths", "files", "logs"):
            return [part for part in text.split(os.pathsep) if part]
        return text.split() if setting.kind == "assignments" else text

    return lookup


def taken_for_root(arguments: Sequence[str], here: Path, asked: Sequence[Path], root: Path) -> str | None:
    """What to write where a path behind a `--dvp-` option has led pytest to another root folder.

    pytest looks for its ini file before it knows the options of plugins, and takes PATH of `--option PATH` for one that
    it is to run: it starts there, and in a project elsewhere finds another ini file, or nothing to run.

    arguments: as pytest got them, in the folder `here`; asked: what is to be run; root: pytest's root folder.
    """
    if any(place.is_relative_to(root) and _nearest_ini(place, root) in (None, root) for place in asked):
        return None
    for option, value in itertools.pairwise(arguments):
        if option.startswith("--dvp-") and "=" not in option and (here / value).exists():
            where = f"pytest takes this path for what to run (root folder {root})"
            return f"{option} {value}: {where}; write {option}={value}"
    return None


def _nearest_ini(place: Path, root: Path) -> Path | None:
    """The folder of the pytest.ini that is nearest to a place, up to the root folder."""
    for folder in (place, *place.parents):
        if any((folder / name).is_file() for name in (".pytest.ini", "pytest.ini")):
            return folder
        if folder == root:
            break
    return None


def _number(setting: Setting, text: str, origin: str) -> int | float:
    what = "a whole number" if setting.kind == "int" else "a number"
    try:
        if not text.isascii() or "_" in text:  # which only Python takes for one
            raise ValueError
        value: int | float = int(text) if setting.kind == "int" else float(text)
    except ValueError:
        raise SettingError(f"{origin} is {text!r}, expected {what}") from None
    if not math.isfinite(value) or (setting.least is not None and value < setting.least):
        raise SettingError(f"{origin} is {text}, expected {what} >= {setting.least:g}")
    return value


def misspelt_variable(settings: Iterable[Setting]) -> str | None:
    """The first environment variable that is nearly one of the settings' and none, with the one meant."""
    names = (name for name in os.environ if name.startswith("DVP_") and name not in _NO_SETTINGS)
    return misspelt(names, [setting.environment for setting in settings])


def possible_folder(path: Path, origin: str) -> Path:
    """A folder that is there or can be made. Raises SettingError naming `origin`, the option."""
    there = path.absolute()
    while not there.exists() and there != there.parent:
        there = there.parent
    if not there.is_dir():
        raise SettingError(f"{origin} {path}: {there} is no folder")
    if not os.access(there, os.W_OK):
        raise SettingError(f"{origin} {path}: cannot be written: no permission")
    return path.absolute()


def _new_file(path: Path, origin: str) -> Path:
    """A file that can be written, in a folder that is there. Raises SettingError naming `origin`, the option."""
    if path.is_dir():
        raise SettingError(f"{origin} {path}: a folder, expected a file")
    if not path.parent.is_dir():
        raise SettingError(f"{origin} {path}: no folder {path.parent}")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise SettingError(f"{origin} {path}: cannot be written: no permission")
    return path.absolute()


def _missing(origin: str, what: str, path: Path, table: str = "") -> SettingError:
    from pytest_dvp.text.near_path import looked_for

    return SettingError(f"{origin}: {what} {path}{looked_for(path, table)}")


def _file(path: Path, origin: str, table: str = "") -> Path:
    if not path.is_file():
        raise _missing(origin, "no file", path, table)
    return path.absolute()


def _log(path: Path, origin: str) -> Path:
    if unfinished := told_of(path):
        raise SettingError(f"{origin}: {unfinished}")
    if not path.is_file() and not (path / "log.mcap").is_file():
        raise _missing(origin, "no log or run folder", path)
    return path.absolute()


def _folder(path: Path, origin: str) -> Path:
    if not path.is_dir():
        raise _missing(origin, "no folder", path)
    return path.absolute()
