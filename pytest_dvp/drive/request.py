"""Request: everything that was asked of one run."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.drive.compute_delay import ComputeDelay, parse_delay
from pytest_dvp.drive.option import LISTS, Setting
from pytest_dvp.drive.run_spec import OPTIONS, RunSpec
from pytest_dvp.drive.stack_host import find_ads
from pytest_dvp.text.errors import SettingError
from pytest_dvp.text.spelling import unknown

if TYPE_CHECKING:
    from pytest_dvp.drive.chosen_stack import Ads

KEYWORDS = {keyword: setting for setting in OPTIONS for keyword, *_ in setting.keywords}


class UnknownKeyword(SettingError, TypeError):
    """A keyword that `pytest_dvp.run()` does not have."""


@dataclasses.dataclass(frozen=True)
class Request:
    """The options of a run, and what they were read into.

    spec        the options; what follows stands for those of its fields that a command line gives as words
    parameters  of the scenario; P of the driving stack, S of the simulator
    rootdir     None: none was given
    ads         None: the reference stack
    """

    path: Path
    spec: RunSpec
    parameters: Mapping[str, str | float | bool] = dataclasses.field(default_factory=dict)
    P: Mapping[str, str | float] = dataclasses.field(default_factory=dict)
    S: Mapping[str, str | float] = dataclasses.field(default_factory=dict)
    rootdir: Path | None = None
    ads: Ads | None = None
    compute_delay: ComputeDelay | None = None

    def rehearsal(self) -> dict[str, Any]:
        """The keywords of `pytest_dvp.run()` by which the twin rehearses this drive, without its stack."""
        settings = [setting for setting in OPTIONS if setting.rehearsed and setting.kind != "assignments"]
        told = {setting.keywords[0][0]: getattr(self.spec, setting.key) for setting in settings}
        return {**told, "rootdir": self.rootdir, "parameters": self.parameters, "P": self.P, "S": self.S}


def spec_of(options: Mapping[str, Any]) -> RunSpec:
    """The options that keywords of `pytest_dvp.run()` set; stack, assignments and rootdir are in a `Request` alone.

    Raises UnknownKeyword, which names the nearest one.
    """
    for keyword in options:
        if keyword not in KEYWORDS:
            raise UnknownKeyword(unknown("option of run()", keyword, KEYWORDS))
    left_out = ("ads", "rootdir")
    values = {
        setting.key: _plain(setting, options[keyword])
        for keyword, setting in KEYWORDS.items()
        if keyword in options and setting.key not in left_out and setting.kind != "assignments"
    }
    return RunSpec(**values)


def request_of(path: Path, options: Mapping[str, Any], spec: RunSpec | None = None) -> Request:
    """What a call of `pytest_dvp.run()` asks for.

    spec   the options, where they have been read already

    Raises UnknownKeyword, AdsError for a stack that is not there, and DelayError for a wrong delay.
    """
    spec = spec_of(options) if spec is None else spec
    delay, rootdir = options.get("compute_delay"), options.get("rootdir")
    return Request(
        path=path,
        spec=spec,
        parameters=dict(options.get("parameters") or {}),
        P=dict(options.get("P") or {}),
        S=dict(options.get("S") or {}),
        rootdir=rootdir,
        ads=find_ads(
            options.get("ads"),
            [rootdir] if rootdir is not None else [],
            process=spec.stack_process,
            tick_limit=spec.tick_limit,
        ),
        compute_delay=None if delay is None else parse_delay(delay),
    )


def _plain(setting: Setting, value: Any) -> Any:
    """A value of a keyword as the field has it: paths as paths, lists as tuples."""
    if setting.kind in LISTS:
        return tuple(Path(item) for item in value)
    return Path(value) if setting.kind in ("file", "path", "new_file") and value is not None else value
