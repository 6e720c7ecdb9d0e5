"""LogError: a log file or a column cannot be used."""

from __future__ import annotations

from collections.abc import Sequence

from openscenario.findings import Finding


class LogError(ValueError):
    """A log file or a column cannot be used; the message is one line and names the file or the column.

    code  "log.unreadable", "log.not_mcap", "log.truncated", "log.corrupt", "log.record_too_long", "log.foreign" (valid
          MCAP, not made by us), "log.too_large" (for the budget), "log.unwritable", "log.invalid", or that of the first
          error of `findings`
    findings  what an import found, each with its line and column; empty for what has no place
    """

    def __init__(self, message: str, code: str = "log.invalid", findings: Sequence[Finding] = ()) -> None:
        super().__init__(message)
        self.code = code
        self.findings: tuple[Finding, ...] = tuple(findings)

    def __reduce__(self) -> tuple[type[LogError], tuple[str, str, tuple[Finding, ...]]]:
        return (LogError, (str(self), self.code, self.findings))

    @classmethod
    def of(cls, findings: Sequence[Finding]) -> LogError:
        """The error that tells the first error of `findings`, and how many more there are."""
        errors = [finding for finding in findings if finding.severity == "error"]
        more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
        return cls(f"{errors[0]}{more}", errors[0].code, findings)
