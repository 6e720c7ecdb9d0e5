"""The ini file of a project: found and read by the rules of pytest, so that `dvp` has the same settings.

Standard library only, as pytest itself costs more than many a command of `dvp`.
"""

from __future__ import annotations

import configparser
import dataclasses
import functools
import shlex
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path

from pytest_dvp.drive.option import LISTS, Setting
from pytest_dvp.drive.run_spec import SETTINGS
from pytest_dvp.text.errors import SettingError
from pytest_dvp.text.paths import shown

NAMES = ("pytest.toml", ".pytest.toml", "pytest.ini", ".pytest.ini", "pyproject.toml", "tox.ini", "setup.cfg")
"""In the order in which pytest looks for them in a folder."""
_ALWAYS = ("pytest.toml", ".pytest.toml", "pytest.ini", ".pytest.ini")  # configure pytest even if they are empty
_PERMITS = ("library",)  # lets files be read, and changes nothing of a run that could read them all
_SECTION = {"setup.cfg": "tool:pytest"}  # of the others it is "pytest"


@dataclasses.dataclass(frozen=True)
class IniFile:
    """What configures pytest: the file, and the keys that it sets."""

    file: Path
    keys: Mapping[str, object]

    def origin(self, setting: Setting) -> str:
        """`pytest.ini: dvp_seed`: where a setting of this file stands, for messages."""
        return f"{shown(self.file)}: {setting.ini}"

    def value(self, setting: Setting) -> object:
        """What the file says of a setting, lists split as pytest does; None if nothing. Raises SettingError."""
        told = self.keys.get(setting.ini)
        if told is None:
            return None
        if setting.kind not in LISTS:
            if isinstance(told, list | dict):
                raise SettingError(f"{self.origin(setting)} is {told}, expected one value")
            return str(told)
        if isinstance(told, list):
            return [str(word) for word in told]
        try:
            return shlex.split(str(told))
        except ValueError as error:  # a quotation mark without its other one
            raise SettingError(f"{self.origin(setting)} is {str(told)!r}: {error}") from None


def find_ini(start: Path) -> IniFile | None:
    """The file that configures pytest in the folder `start`: in it, else in the nearest folder above.

    Raises SettingError for a file that cannot be read.
    """
    for folder in (start, *start.parents):
        for name in NAMES:
            file = folder / name
            if file.is_file():
                stat = file.stat()
                keys = _keys(file, stat.st_mtime_ns, stat.st_size)
                if keys is not None:
                    return IniFile(file, keys)
    return None


def changes_a_run(words: Sequence[str], stage: str) -> bool:
    """Whether the ini file here sets something for a run on `stage` that the words of its command leave out.

    They leave out what has its default: a command that must do the same again then needs `--no-ini`.
    """
    try:
        ini = find_ini(Path.cwd())
    except SettingError:  # the command will say so
        return False
    if ini is None:
        return False
    shaping = [setting for setting in SETTINGS if setting.replay and setting.name not in _PERMITS]
    counting = [setting for setting in shaping if stage in setting.stages or "dt" in setting.stages]
    left_out = [setting for setting in counting if f"--{setting.name}" not in words]
    return any(str(ini.keys.get(setting.ini, setting.default)) != str(setting.default) for setting in left_out)


@functools.lru_cache(maxsize=8)
def _keys(file: Path, changed: int, size: int) -> Mapping[str, object] | None:
    """The keys of the table or section for pytest; None if the file does not configure pytest.

    Kept while the file stays as it is: a campaign asks for them in each drive.
    """
    try:
        text = file.read_text(encoding="utf-8-sig")
        found = _of_toml(file, text) if file.suffix == ".toml" else _of_ini(file, text)
    except OSError as error:
        raise SettingError(f"{shown(file)}: cannot be read: {error.strerror}") from None
    except (ValueError, configparser.Error) as error:  # not UTF-8, not TOML, not an ini file
        raise SettingError(f"{shown(file)}: cannot be read: {' '.join(str(error).split())}") from None
    return {} if found is None and file.name in _ALWAYS else found


def _of_toml(file: Path, text: str) -> Mapping[str, object] | None:
    data = tomllib.loads(text)
    if file.name != "pyproject.toml":
        table = data.get("pytest")
    else:
        tool = data.get("tool")
        table = tool.get("pytest") if isinstance(tool, dict) else None
        if isinstance(table, dict) and "ini_options" in table:
            table = table["ini_options"]
    return table if isinstance(table, dict) else None


def _of_ini(file: Path, text: str) -> Mapping[str, object] | None:
    ini = configparser.ConfigParser(interpolation=None, strict=False)
    ini.optionxform = str  # type: ignore[assignment,method-assign]  # keys as they are written
    ini.read_string(text, source=file.name)
    section = _SECTION.get(file.name, "pytest")
    return dict(ini[section]) if ini.has_section(section) else None
