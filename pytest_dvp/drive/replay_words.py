"""The options of a printed command that repeats a run or a comparison of stages, in the order that RunSpec declares."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pytest_dvp.drive.option import Setting
from pytest_dvp.drive.run_spec import OPTIONS, RunSpec
from pytest_dvp.text.names import REFERENCE
from pytest_dvp.text.paths import shown

RUN = sorted((setting for setting in OPTIONS if setting.replay), key=lambda setting: setting.replay)
COMPARISON = sorted((setting for setting in OPTIONS if setting.compared), key=lambda setting: setting.compared)


def words_of_run(spec: RunSpec, ads: str | None, given: Mapping[str, str], delay: str | None) -> list[str]:
    """`--seed 7 ...` of all that is not at its default and counts on the stage of the run.

    ads     what `--ads` takes; given: what `--set` takes, value by name; delay: what `--compute-delay` takes
    """
    told = {"ads": ads or REFERENCE, "set": given, "compute-delay": delay}
    return [word for setting in RUN if spec.stage in setting.stages or "dt" in setting.stages
            for word in _words(setting, spec, told)]  # fmt: skip


def words_of_comparison(spec: RunSpec, ads: str, given: Mapping[str, str]) -> list[str]:
    """The same for a comparison of stages; `--stage` is not among them."""
    return [word for setting in COMPARISON for word in _words(setting, spec, {"ads": ads, "set": given})]


def _words(setting: Setting, spec: RunSpec, told: Mapping[str, Any]) -> list[str]:
    value = told[setting.name] if setting.name in told else getattr(spec, setting.key)
    if not setting.always and (value == setting.default or value is None):
        return []
    return [word for text in _texts(setting, value) for word in ([f"--{setting.name}", *text])]


def _texts(setting: Setting, value: Any) -> Iterator[list[str]]:
    """The value behind the option, once for each time that the option stands there."""
    if setting.kind == "assignments":
        yield from ([f"{name}={told}"] for name, told in sorted(value.items()))
    elif setting.kind in ("paths", "files", "logs"):
        yield from ([shown(Path(path))] for path in value)
    elif setting.kind in ("file", "path"):
        yield [shown(value)]
    elif setting.kind == "flag":
        yield []
    else:
        yield [f"{value:g}" if setting.kind == "float" else str(value)]
