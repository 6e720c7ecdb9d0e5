"""The log that physics may be fitted to: read, examined, refused if something is wrong with it."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from openscenario.findings import Finding
from pytest_dvp.doctor.comparable_log import comparable
from pytest_dvp.doctor.examine import examine
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.read_log import read_log


def read_checked_log(argument: str | Path, *, output: bool = False, **options: Any) -> tuple[Log, tuple[Finding, ...]]:
    """What of a log can be compared, and its warnings; `options` are those of read_log, `output` as of examine.

    Raises LogError with all findings if one of them is an error: degrees taken for radians and the like, which a model
    would be bent to explain.
    """
    log = read_log(argument, **options)
    findings = check_log(log, file=str(argument), line=3, output=output)
    return log if output else comparable(log), findings


def check_log(log: Log, *, file: str = "", line: int | None = None, output: bool = False) -> tuple[Finding, ...]:
    """The warnings about a log; arguments as of examine. Raises LogError with all findings if one is an error."""
    findings = examine(log, file=file, line=line, output=output)
    if any(finding.severity == "error" for finding in findings):
        raise LogError.of(findings)
    return findings


def print_findings(findings: Iterable[Finding]) -> None:
    """One line each on stderr: stdout belongs to the answer."""
    for finding in findings:
        print(finding, file=sys.stderr)
