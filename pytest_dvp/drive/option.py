"""Option: how a field of `RunSpec` declares an option of a run, and what the ways to set it are called.

Imports the standard library only: the pytest plugin reads it at start-up.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any, Literal

Kind = Literal[
    "int",
    "float",
    "size",
    "str",
    "path",
    "file",
    "new_file",
    "flag",
    "ads",
    "delay",
    "assignments",
    "paths",
    "files",
    "logs",
]
LISTS: tuple[Kind, ...] = ("assignments", "paths", "files", "logs")

Home = Literal["run", "reading", "pytest", "python"]
"""Who has an option: a run (pytest, `dvp run` and `run()`); besides pytest every `dvp` command that reads a log; the
pytest plugin alone, as only it collects; only Python code that calls `run()`."""

STAGES: tuple[str, ...] = ("dt", "pe", "rw")
OF_A_CAR = ("pe", "rw")

_METADATA = "option"


@dataclasses.dataclass(frozen=True)
class Setting:
    """One option: `--dvp-NAME` of pytest, `--NAME` of dvp, `dvp_NAME` in an ini file, variable `DVP_NAME`.

    metavar   what stands for the value in the help
    least     smallest number; choices: all values there are; allowed: what is allowed, in words
    unit      of the value
    more      what the help of a command has no room for
    keywords  those of `run()` that set it, each with its type, and its meaning if that is not the help
    stages    on which it counts
    replay    place among the options of the command that repeats a run; 0: it is not among them
    compared  place among those of the command that repeats a comparison of stages; 0: it is not among them
    always    it is in such a command even if it has its default
    rehearsed the twin that rehearses a drive in real time has it, too
    """

    name: str
    kind: Kind
    default: Any
    help: str
    metavar: str | None = None
    least: float | None = None
    choices: tuple[str, ...] = ()
    allowed: str = ""
    unit: str = ""
    more: str = ""
    home: Home = "run"
    keywords: tuple[tuple[str, str, str], ...] = ()
    stages: tuple[str, ...] = STAGES
    replay: int = 0
    compared: int = 0
    always: bool = False
    rehearsed: bool = False

    @property
    def key(self) -> str:
        """The name as a field of RunSpec and a keyword of `run()`: `stack-limit` is `stack_limit`."""
        return self.name.replace("-", "_")

    @property
    def ini(self) -> str:
        """The key in the ini file of pytest."""
        return f"dvp_{self.key}"

    @property
    def environment(self) -> str:
        """The environment variable."""
        return f"DVP_{self.key.upper()}"


_TYPES: dict[Kind, str] = {
    "int": "int",
    "float": "float",
    "size": "int",
    "flag": "bool",
    "path": "str | Path",
    "file": "str | Path",
    "new_file": "str | Path",
    "paths": "Sequence[str | Path]",
    "files": "Sequence[str | Path]",
    "logs": "Sequence[str | Path]",
}
"""Type of the keyword of `run()` by the kind of its option; of the others it is str."""


def option(
    kind: Kind,
    default: Any,
    help: str,
    metavar: str | None = None,
    least: float | None = None,
    *,
    factory: Callable[[], Any] | None = None,
    keyword: str | None = None,
    **declared: Any,
) -> Any:
    """A field of `RunSpec`: default of the field, and everything else about the option (see `Setting`).

    factory   makes the default of the field where it is not one value
    keyword   of `run()`; default the name of the field, "" for an option that `run()` does not have
    declared  further attributes of `Setting`
    """
    metadata = {"kind": kind, "default": default, "help": help, "metavar": metavar, "least": least, **declared}
    metadata["keyword"] = keyword
    if factory is not None:
        return dataclasses.field(default_factory=factory, metadata={_METADATA: metadata})
    return dataclasses.field(default=default, metadata={_METADATA: metadata})


def settings_of(spec: type) -> tuple[Setting, ...]:
    """The options that the fields of a dataclass declare, in their order."""
    fields = [field for field in dataclasses.fields(spec) if _METADATA in field.metadata]
    return tuple(_setting(field.name, dict(field.metadata[_METADATA])) for field in fields)


def _setting(key: str, declared: dict[str, Any]) -> Setting:
    keyword, home = declared.pop("keyword"), declared.get("home", "run")
    if "keywords" not in declared and home in ("run", "python") and keyword != "":
        usual = _TYPES.get(declared["kind"], "str") + (" | None" if declared["default"] is None else "")
        declared["keywords"] = ((keyword or key, usual, ""),)
    return Setting(name=key.replace("_", "-"), **declared)
