"""Assertions for a user's own tests."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeGuard, cast

if TYPE_CHECKING:
    import pandas as pd

    from openscenario.findings import Finding
    from pytest_dvp.gap.compare.compare import Comparable, Comparison
    from pytest_dvp.gap.compare.compared_model import ComparedModel
    from pytest_dvp.logs.log import Log
    from vehicle.model.effect import Effect


def assert_matches(
    log: Log | pd.DataFrame | str | Path,
    model: Comparable | pd.DataFrame | str | Path,
    *,
    rmse: Mapping[str, float] | None = None,
    mncc: Mapping[str, float] | None = None,
    lag: float | Mapping[str, float] | None = None,
    gain: float | Mapping[str, float] | None = None,
    channels: Collection[str] | None = None,
    effects: Sequence[str | Path] = (),
    map: str | Path | None = None,
    msg_dirs: Sequence[Path] = (),
) -> Comparison:
    """Assert that a model answers a measured log's commands as the car did.

    log, model  as for `dvp compare`: files (the log may be cut, "drive.csv@0:285"), or a Log, a pandas DataFrame with
                a column t [s] (a bare column name means SI, "v [km/h]" is converted), a VehicleModel, a black box,
                a second Log or DataFrame
    rmse        largest RMSE by signal [the signal's unit], on segments of about 5 s with the start taken out
    mncc        least maximum normalised cross-correlation by signal; blind to gain and delay, so bound these too
    lag, gain   largest |lag| [s] and |gain - 1|, by signal, or one number for every signal that tells them
    effects     Python files with effects of your own that the model file uses (`--effects`); they are run
    map, msg_dirs  how a foreign log is to be read (`--map`, `--msg`); of a model that is a log, as far as it fits

    Returns the comparison. Raises AssertionError that says how far apart and where, which effect the model most likely
    lacks and the command that adds it (seconds of work, `--dvp-no-diagnosis` leaves it out), and ValueError if no bound
    is given, if one is no finite number >= 0 (mncc: from 0 to 1), or if `map` has no file to read; CompareError,
    LogError or ModelError if the files cannot be compared. A log file that `dvp doctor` finds errors in is refused with
    LogError, a DataFrame alike, be it of the model; its warnings are printed on stderr. Of a Log as of a file, spikes
    and commands that the car did not obey (`engaged`) count as not measured.
    """
    __tracebackhide__ = True
    bounds = {"rmse": rmse, "mncc": mncc, "lag": lag, "gain": gain}
    if all(not isinstance(bound, float | int) and not bound for bound in bounds.values()):
        raise ValueError("assert_matches: no bound is given; pass rmse, mncc, lag or gain")
    if map is not None and not (isinstance(log, str | Path) or _is_log_file(model)):
        raise ValueError(f"assert_matches: no file that the mapping {map} could read; name the columns of a DataFrame")
    from pytest_dvp.doctor import print_findings
    from pytest_dvp.gap.compare.compare import compare
    from pytest_dvp.gap.compare.compared_model import LogSubject
    from pytest_dvp.gap.compare.match_bounds import check_bounds, judge_bounds
    from pytest_dvp.gap.words.comparison import failure

    check_bounds(bounds)
    measured, findings = _measured(log, None if map is None else Path(map), msg_dirs)
    print_findings(findings)
    subject = _subject(model, effects, None if map is None else Path(map), msg_dirs)
    print_findings(subject.findings if isinstance(subject, LogSubject) else ())
    comparison = compare(measured, subject, channels=channels)
    judged = judge_bounds(comparison, bounds)
    if any(not one.holds for one in judged):
        lines = [failure(comparison, judged)]
        if any(not one.holds and one.value is not None for one in judged):  # what has no number no effect explains
            lines += _explanation(measured, subject, log, model, effects, map)
        raise AssertionError("\n".join(lines))
    return comparison


def _explanation(measured: Log, subject: ComparedModel, log: object, model: object, effects: Sequence[str | Path],
                 mapping: str | Path | None) -> list[str]:  # fmt: skip
    """What the model lacks, if it is one to which effects can be added; not for each example of a search."""
    from pytest_dvp.gap.compare.compared_model import ModelSubject
    from pytest_dvp.gap.diagnosis_switch import diagnosis_wanted
    from pytest_dvp.text.searching import searching

    if not isinstance(subject, ModelSubject) or searching() or not diagnosis_wanted():
        return []
    from pytest_dvp.gap.words.failure_explanation import explanation

    options = [word for file in _files(effects) for word in ("--effects", str(file))]
    options += ["--map", str(mapping)] if mapping is not None else []
    names = {
        key: str(thing) for key, thing in (("log_name", log), ("model_name", model)) if isinstance(thing, str | Path)
    }
    extra = tuple(_own(effects).values())
    return explanation(measured, subject.model, effects=extra, options=options, **names)


def _measured(
    log: Log | pd.DataFrame | str | Path, mapping: Path | None, msg_dirs: Sequence[Path]
) -> tuple[Log, tuple[Finding, ...]]:
    """The log that is meant, with the doctor's warnings if it was read here."""
    from pytest_dvp.doctor import check_log, comparable, read_checked_log
    from pytest_dvp.logs.dataframe import frame_log
    from pytest_dvp.logs.log import Log

    if isinstance(log, str | Path):
        return read_checked_log(log, mapping=mapping, msg_dirs=msg_dirs)
    if isinstance(log, Log):
        return comparable(log), ()
    if _is_frame(log):
        found = frame_log(log)
        warnings = check_log(found, file="DataFrame")
        return comparable(found), warnings
    raise TypeError(f"assert_matches: log is a {type(log).__name__}; allowed: a file's name, a Log, a pandas DataFrame")


def _subject(
    model: Comparable | pd.DataFrame | str | Path, effects: Sequence[str | Path], mapping: Path | None,
    msg_dirs: Sequence[Path],
) -> ComparedModel:  # fmt: skip
    from pytest_dvp.doctor import check_log
    from pytest_dvp.gap.compare.compare import as_subject
    from pytest_dvp.gap.compare.compared_model import LogSubject
    from pytest_dvp.gap.compare.model_loader import load_compared_model
    from pytest_dvp.logs.dataframe import frame_log

    if isinstance(model, str | Path):
        return load_compared_model(str(model), _own(effects), mapping=mapping, msg_dirs=msg_dirs)
    if _is_frame(model):
        output = frame_log(model, "DataFrame of the model")
        findings = check_log(output, file="DataFrame of the model", output=True)
        return LogSubject(output, findings=findings, extra=_own(effects).values())
    found = as_subject(cast("Comparable", model))
    if not hasattr(found, "output"):
        kind = type(model).__name__
        raise TypeError(
            f"assert_matches: model is a {kind}; allowed: a file's name, a VehicleModel, a black box, a log"
        )
    return found


def _is_log_file(model: object) -> bool:
    """Whether a model is the file of a second log."""
    name = str(model)
    return isinstance(model, str | Path) and ".py:" not in name and not name.endswith((".toml", ".py", ".fmu"))


def _is_frame(thing: object) -> TypeGuard[pd.DataFrame]:
    """Told by what it has, as pandas need not be imported for everybody."""
    return hasattr(thing, "iloc") and hasattr(thing, "columns")


def _own(files: Sequence[str | Path]) -> dict[str, Effect]:
    if not files:
        return {}
    from vehicle.model.effect_catalogue import effects_of_files

    return effects_of_files(_files(files))


def _files(files: Sequence[str | Path]) -> list[Path]:
    return [Path(file) for file in ([files] if isinstance(files, str | Path) else files)]
