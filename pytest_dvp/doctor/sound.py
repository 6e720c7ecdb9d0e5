"""The log that physics may be fitted to: read, examined, refused if something is wrong with it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from openscenario.findings import Finding
from pytest_dvp.doctor.examine import examine
from pytest_dvp.log import Log, LogError
from pytest_dvp.logs.read import read_log


def read_sound(argument: str | Path, **options: Any) -> tuple[Log, tuple[Finding, ...]]:
    """A log and the warnings about it; `options` are those of read_log.

    Raises LogError with all findings if one of them is an error: degrees taken for radians and the like, which a model
    would be bent to explain.
    """
    log = read_log(argument, **options)
    findings = examine(log, file=str(argument), line=3)
    if any(finding.severity == "error" for finding in findings):
        raise LogError.of(findings)
    return log, findings
