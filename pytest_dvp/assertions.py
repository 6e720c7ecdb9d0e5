"""Assertions for a user's own tests."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pytest_dvp.log import Log
    from pytest_dvp.reality_gap.compare import Comparable, Comparison


def assert_matches(
    log: Log | str | Path,
    model: Comparable | str | Path,
    *,
    rmse: Mapping[str, float] | None = None,
    mncc: Mapping[str, float] | None = None,
    lag: float | Mapping[str, float] | None = None,
    gain: float | Mapping[str, float] | None = None,
    channels: Collection[str] | None = None,
    mapping: Path | None = None,
    msg_dirs: Sequence[Path] = (),
) -> Comparison:
    """Assert that a model answers a measured log's commands as the car did.

    log, model  as for `dvp compare`: files (the log may be cut, "drive.csv@0:285"), or a Log, a VehicleModel, a black
                box, a second Log
    rmse        largest RMSE by signal [the signal's unit], on segments of about 5 s with the start taken out
    mncc        least maximum normalised cross-correlation by signal; blind to gain and delay, so bound these too
    lag, gain   largest |lag| [s] and |gain - 1|, by signal, or one number for every signal that tells them
    mapping, msg_dirs  how a foreign log is to be read (`--map`, `--msg`); for `log` alone

    Returns the comparison. Raises AssertionError that says how far apart and where, and ValueError if no bound is
    given; CompareError, LogError or ModelError if the files cannot be compared. A log file that `dvp doctor` finds
    errors in is refused with LogError; its warnings are printed on stderr.
    """
    __tracebackhide__ = True
    bounds = {"rmse": rmse, "mncc": mncc, "lag": lag, "gain": gain}
    if all(not isinstance(bound, float | int) and not bound for bound in bounds.values()):
        raise ValueError("assert_matches: no bound is given; pass rmse, mncc, lag or gain")
    from pytest_dvp.doctor import read_sound, tell
    from pytest_dvp.reality_gap.black_box import LogSubject, load_subject
    from pytest_dvp.reality_gap.bounds import judge_bounds
    from pytest_dvp.reality_gap.compare import compare
    from pytest_dvp.reality_gap.words import failure

    if isinstance(log, str | Path):
        measured, findings = read_sound(log, mapping=mapping, msg_dirs=msg_dirs)
        tell(findings)
    else:
        measured = log
    subject = load_subject(str(model)) if isinstance(model, str | Path) else model
    tell(subject.findings if isinstance(subject, LogSubject) else ())
    comparison = compare(measured, subject, channels=channels)
    judged = judge_bounds(comparison, bounds)
    if any(not one.holds for one in judged):
        raise AssertionError(failure(comparison, judged))
    return comparison
