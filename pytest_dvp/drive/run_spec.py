"""Settings of a run: one table for the pytest options, their ini and environment twins, and the command line.

Imports the standard library only: the pytest plugin reads it at start-up.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from pytest_dvp.drive.assignments import Assignments, parse_assignments
from pytest_dvp.logs.budget import SIZE_FORM, Budget, parse_size
from pytest_dvp.logs.unfinished_run import told_of
from pytest_dvp.text.errors import SettingError
from pytest_dvp.text.flags import is_on
from pytest_dvp.text.names import REFERENCE
from pytest_dvp.text.spelling import unknown

Kind = Literal[
    "int", "float", "size", "str", "path", "file", "flag", "ads", "delay", "assignments", "paths", "files", "logs"
]

LISTS: tuple[Kind, ...] = ("assignments", "paths", "files", "logs")
STAGES: tuple[str, ...] = ("dt", "pe", "rw")
SIMULATED = ("surrogate", "can", "replay")  # vehicles of ours, none of which is a car


@dataclasses.dataclass(frozen=True)
class Setting:
    """One setting: `--dvp-NAME` of pytest, `--NAME` of dvp, `dvp_NAME` in an ini file, variable `DVP_NAME`."""

    name: str
    kind: Kind
    default: Any
    help: str
    metavar: str | None = None
    least: float | None = None
    choices: tuple[str, ...] = ()

    @property
    def key(self) -> str:
        return self.name.replace("-", "_")

    @property
    def ini(self) -> str:
        return f"dvp_{self.key}"

    @property
    def environment(self) -> str:
        return f"DVP_{self.key.upper()}"


SETTINGS: tuple[Setting, ...] = (
    Setting("seed", "int", 7, "seed of every random number of a run", "N", 0),
    Setting(
        "ads",
        "ads",
        REFERENCE,
        "driving stack: entry point of pytest_dvp.ads, module:Class, FILE.py:Class, ros2:F.toml",
        "NAME",
    ),
    Setting("model", "file", None, "vehicle model (TOML); default: the TABBY EVO", "FILE"),
    Setting("effects", "files", (), "effects of your own that the model uses; the file is run", "FILE.py"),
    Setting("gates", "file", None, "gate file; default: NAME.gates.toml beside the scenario", "FILE"),
    Setting("stage-gates", "file", None, "further gates between stages, for every scenario", "FILE"),
    Setting("stage-logs", "logs", (), "log or run folder of a stage driven earlier, to compare with", "LOG"),
    Setting("library", "paths", (), "folder that scenarios may refer to, besides their own and the rootdir", "DIR"),
    Setting(
        "reading",
        "str",
        "esmini",
        "of three rules where that player and the standard differ: esmini or standard (docs/conformance.md)",
        "NAME",
        choices=("esmini", "standard"),
    ),
    Setting("ego", "str", None, "entity that the ADS drives; default: Ego", "NAME"),
    Setting("set", "assignments", (), "NAME=VALUE of a declared parameter, P.NAME=VALUE (ADS), S.NAME=VALUE", "A"),
    Setting(
        "cases", "int", None, "cases of a distribution that run, a random sample by the seed; default: all", "N", 1
    ),
    Setting("duration", "float", None, "longest simulated time [s]; default: 60, with a goal 300", "SECONDS", 0.05),
    Setting("wall-limit", "float", 600.0, "longest wall time of one run [s]", "SECONDS", 0.1),
    Setting(
        "tick-limit",
        "float",
        10.0,
        "longest wall time of one tick of the stack [s]; six times that for the first one and for loading it",
        "SECONDS",
        0.01,
    ),
    Setting(
        "stack-process",
        "str",
        None,
        "whether a stack given by name runs in a process of its own: on or off; default: on, the reference stack: off",
        "on|off",
        choices=("on", "off"),
    ),
    Setting(
        "compute-delay",
        "delay",
        None,
        "stage dt: commands reach the car later, and a share of them never: SECONDS[+-JITTER][,drop=SHARE]",
        "DELAY",
    ),
    Setting(
        "after-collision", "float", 1.0, "simulated time from a collision to the end of the run [s]", "SECONDS", 0.0
    ),
    Setting(
        "vehicle",
        "str",
        "surrogate",
        "car of stages pe and rw: surrogate or can (:HIDDEN.toml), ros1 (:FILE), replay:LOG, ros2_car:N or yours",
        "NAME",
    ),
    Setting("dbc", "file", None, "messages of a vehicle on CAN, its signal map beside it; default: our own", "F.dbc"),
    Setting("fault", "str", None, "what goes wrong on the wire to the surrogate, as drop@5+3 (s)", "NAME"),
    Setting("clock", "str", "stepped", "time of stages pe and rw: stepped (lock-step) or real (wall clock)", "NAME"),
    Setting("arming", "file", None, "second key of a real car: a file for this vehicle and scenario, used up", "FILE"),
    Setting("envelope", "file", None, "where and how fast a real car may drive (TOML: area, max_speed)", "FILE"),
    Setting(
        "max-log-bytes", "size", None, "most that a log unpacks to, as 2GB; default: 200 times its file", "BYTES", 1
    ),
    Setting("max-log-rows", "int", None, "most rows, or messages, of a log; default: 50 million", "N", 1),
    Setting("max-file-bytes", "size", None, "largest log file; default: 64 GiB, of CSV and .mat 512 MiB", "BYTES"),
    Setting("runs", "path", None, "folder of the run folders; default: ROOTDIR/runs", "DIR"),
    Setting("single-file", "flag", False, "a report of one file: it shares nothing with the other runs (2 MB more)"),
    Setting("require-real", "flag", False, "a surrogate in the place of a real vehicle is an ERROR"),
)
BUDGET: tuple[str, ...] = ("max-log-bytes", "max-log-rows", "max-file-bytes")
"""How large the logs may be that are read: every command that reads one has these settings."""
# Only the pytest plugin collects, so only it has these.
PLUGIN_SETTINGS: tuple[Setting, ...] = (
    Setting(
        "scenarios", "paths", (), "folder whose .xosc files are collected, besides those on the command line", "DIR"
    ),
    Setting("no-diagnosis", "flag", False, "a model that does not match is not diagnosed (it costs seconds)"),
)


@dataclasses.dataclass(frozen=True)
class Settings:
    """The values in force. Times [s]; `runs` and `rootdir` absolute; `origins` of those that were set, by key."""

    seed: int = 7
    ads: str = REFERENCE
    model: Path | None = None
    effects: tuple[Path, ...] = ()
    gates: Path | None = None
    stage_gates: Path | None = None
    stage_logs: tuple[Path, ...] = ()
    library: tuple[Path, ...] = ()
    reading: Literal["esmini", "standard"] = "esmini"
    ego: str | None = None
    set: Assignments = dataclasses.field(default_factory=Assignments)
    cases: int | None = None
    duration: float | None = None
    wall_limit: float = 600.0
    tick_limit: float = 10.0
    stack_process: str | None = None
    compute_delay: str | None = None
    after_collision: float = 1.0
    vehicle: str = "surrogate"
    dbc: Path | None = None
    fault: str | None = None
    clock: str = "stepped"
    arming: Path | None = None
    envelope: Path | None = None
    max_log_bytes: int | None = None
    max_log_rows: int | None = None
    max_file_bytes: int | None = None
    runs: Path | None = None
    single_file: bool = False
    require_real: bool = False
    scenarios: tuple[Path, ...] = ()
    no_diagnosis: bool = False
    rootdir: Path = dataclasses.field(default_factory=Path.cwd)
    origins: Mapping[str, str] = dataclasses.field(default_factory=dict, compare=False, repr=False)

    def origin(self, name: str) -> str:
        """Where a setting was set, for messages: `--ads`, `environment DVP_ADS`, `pytest.ini: dvp_ads`."""
        return self.origins.get(name.replace("-", "_"), f"--{name}")

    @property
    def runs_folder(self) -> Path:
        return self.runs if self.runs is not None else self.rootdir / "runs"

    @property
    def budget(self) -> Budget:
        """How large the logs may be that are read."""
        return Budget(self.max_log_bytes, self.max_log_rows, self.max_file_bytes)


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
        except ValueError:
            raise SettingError(f"{origin} is {text!r}, expected {SIZE_FORM}") from None
    if setting.kind == "path":
        return possible_folder(base / text, origin)
    if setting.kind == "file":
        return _file(base / text, origin)
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
) -> Settings:
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
    return Settings(rootdir=rootdir, origins=origins, **values)


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


def _missing(origin: str, what: str, path: Path) -> SettingError:
    from pytest_dvp.text.near_path import looked_for

    return SettingError(f"{origin}: {what} {path}{looked_for(path)}")


def _file(path: Path, origin: str) -> Path:
    if not path.is_file():
        raise _missing(origin, "no file", path)
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
