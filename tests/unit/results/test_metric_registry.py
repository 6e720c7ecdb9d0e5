"""The catalogue: complete, documented, open to others; and no way for an undefined value to pass."""

from __future__ import annotations

import gc
import math
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from results_logs import drive_straight, log_of, times, track

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import DetectionTable
from pytest_dvp.metrics import Measured, MetricError, compute, find_metric, known_metrics, metric, registry
from pytest_dvp.metrics.metric import Metric

PAPER = {"max_ttc_inverse", "tet", "max_jerk", "max_yaw_rate", "completion_time", "lateral_rmse", "mncc", "lag", "gain"}
OURS = {"lateral_rmse_path", "collision", "road_departure", "events_fired", "goal_reached", "scenario_ended"}


@pytest.fixture
def fresh_catalogue() -> Iterator[None]:
    known_metrics.cache_clear()
    yield
    known_metrics.cache_clear()


def test_metrics_of_the_paper_and_ours_are_there() -> None:
    assert known_metrics().keys() >= PAPER | OURS


@pytest.mark.parametrize("name", sorted(PAPER | OURS))
def test_metric_states_unit_and_definition(name: str) -> None:
    found = find_metric(name)
    assert found.unit
    assert len(found.definition) > 40


def test_unknown_metric_names_the_nearest() -> None:
    with pytest.raises(MetricError, match="unknown metric 'max_jrk'; nearest is 'max_jerk'"):
        compute("max_jrk", log_of())


def test_unknown_option_names_the_nearest() -> None:
    with pytest.raises(MetricError, match="metric 'max_jerk' has no option 'cutof'; nearest is 'cutoff'"):
        compute("max_jerk", log_of(), cutof=2.0)


@pytest.mark.parametrize("value", [math.nan, math.inf, "2", True])
def test_option_must_be_a_finite_number(value: object) -> None:
    with pytest.raises(MetricError, match="option 'critical' of metric 'tet' must be a finite number"):
        compute("tet", log_of(), critical=value)


def test_option_without_default_is_required() -> None:
    with pytest.raises(MetricError, match="metric 'mncc' needs the option 'signal'"):
        compute("mncc", log_of(), log_of())


def test_metric_of_another_package_is_one_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fresh_catalogue: None
) -> None:
    (tmp_path / "others.py").write_text(
        "from pytest_dvp.metrics import Measured, metric\n"
        '@metric(name="max_speed", unit="m/s", bigger_is_worse=True)\n'
        "def max_speed(log):\n"
        '    "Greatest speed of the run."\n'
        '    worst = log["v"].argmax()\n'
        '    return Measured(log["v"][worst], t=log.t[worst])\n'
    )
    _declare(tmp_path, "others")
    monkeypatch.syspath_prepend(tmp_path)
    assert compute("max_speed", drive_straight(7.5)).value == 7.5


def test_package_that_cannot_be_loaded_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fresh_catalogue: None
) -> None:
    _declare(tmp_path, "absent_package")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(MetricError, match=r"entry point 'mine' of pytest_dvp\.metrics cannot be loaded"):
        known_metrics()


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_value_that_is_not_finite_is_never_valid(value: float, monkeypatch: pytest.MonkeyPatch) -> None:
    @metric(name="odd", unit="-", bigger_is_worse=True)
    def odd(log: object) -> Measured:
        """A value."""
        return Measured(value)

    _know(monkeypatch, odd)
    result = compute("odd", log_of())
    assert (result.value, result.valid) == (None, False)


@pytest.mark.parametrize("name", sorted(PAPER | OURS))
def test_log_without_samples_defines_no_metric(name: str) -> None:
    chosen = find_metric(name)
    empty = log_of(0.0)
    options = {"signal": "v"} if "signal" in chosen.options else {}
    result = compute(name, empty, empty if chosen.logs == 2 else None, **options)
    assert (result.valid, result.reason) == (False, "the log has no samples")


def test_a_metric_of_one_log_is_of_the_first_also_where_another_log_is_there() -> None:
    model, measured = (log_of(columns={"yaw_rate": rate}) for rate in (0.25, 0.5))
    assert compute("max_yaw_rate", model, measured).value == pytest.approx(0.25)
    assert compute("max_yaw_rate", measured, model).value == pytest.approx(0.5)


def test_column_that_is_not_there_makes_a_metric_undefined() -> None:
    log = log_of()
    del log.columns["yaw_rate"]
    result = compute("max_yaw_rate", log)
    assert not result.valid
    assert result.reason.startswith("no column 'yaw_rate'")


def _declare(folder: Path, module: str) -> None:
    info = folder / "others-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: others\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[pytest_dvp.metrics]\nmine = {module}\n")


def _know(monkeypatch: pytest.MonkeyPatch, *more: Metric) -> None:
    table = {**known_metrics(), **{one.name: one for one in more}}
    monkeypatch.setattr(registry, "known_metrics", lambda: table)


def _held(log: Log) -> Measured:
    return Measured(float(log["v"].max()))


def _writes(log: Log) -> Measured:
    log["v"][:] = 0.0
    return _held(log)


def _writes_a_track(log: Log) -> Measured:
    next(iter(log.objects.values())).x[:] = 0.0
    return _held(log)


def _writes_a_detection(log: Log) -> Measured:
    log.detections.x[:] = 0.0
    return _held(log)


def _puts_a_column(log: Log) -> Measured:
    log.columns["v"] = np.zeros(len(log.t))  # type: ignore[index]
    return _held(log)


def _puts_a_track(log: Log) -> Measured:
    log.objects["other"] = next(iter(log.objects.values()))  # type: ignore[index]
    return _held(log)


def _as_a_frame(log: Log) -> Measured:
    return Measured(float(log.to_frame()["v"].max()))


def _which_log(log: Log) -> Measured:
    return Measured(float(id(log)))


def _fails(log: Log) -> Measured:
    raise IndexError("boom")


def _gives_a_number(log: Log) -> Measured:
    return 3.0  # type: ignore[return-value]


FURTHER = {
    "writes": _writes,
    "writes a track": _writes_a_track,
    "writes a detection": _writes_a_detection,
    "puts a column": _puts_a_column,
    "puts a track": _puts_a_track,
    "as a frame": _as_a_frame,
    "which log": _which_log,
    "fails": _fails,
    "number": _gives_a_number,
    "held": _held,
}


@pytest.fixture
def further(monkeypatch: pytest.MonkeyPatch) -> None:
    mine = {name: metric(name=name, unit="m/s", bigger_is_worse=True)(function) for name, function in FURTHER.items()}
    monkeypatch.setattr(registry, "known_metrics", lambda: mine)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("writes", "read-only"),
        ("writes a track", "read-only"),
        ("writes a detection", "read-only"),
        ("puts a column", "does not support item assignment"),
        ("puts a track", "does not support item assignment"),
    ],
)
def test_a_metric_cannot_change_what_was_recorded(further: None, name: str, said: str) -> None:
    """It once wrote into the log, which then passed other gates and was written so."""
    t = times()
    one = np.ones(1)
    seen = DetectionTable(t=one, kind=("car",), x=one, y=one, yaw=one, length=one, width=one, vx=one, vy=one)
    log = drive_straight(5.0, objects={"car": track(t, 12.0, 0.0)}, detections=seen)
    with pytest.raises((ValueError, TypeError), match=said):
        compute(name, log)
    assert (compute("held", log).value, list(log.objects), log.detections.x[0]) == (pytest.approx(5.0), ["car"], 1.0)
    assert compute("as a frame", log).value == pytest.approx(5.0)


def test_whoever_owns_a_log_may_still_write_it(further: None) -> None:
    log = drive_straight(5.0)
    assert compute("held", log).value == pytest.approx(5.0)
    log["v"][0] = 6.0
    assert compute("held", log).value == pytest.approx(6.0)
    log.columns["v"] = np.full(len(log.t), 4.0)  # type: ignore[index]
    assert compute("held", log).value == pytest.approx(4.0)


def test_all_metrics_of_a_log_are_given_the_same_one(further: None) -> None:
    """What several metrics need is kept by the log that they are given."""
    log = drive_straight(5.0)
    assert compute("which log", log).value == compute("which log", log).value != float(id(log))


def test_a_metric_that_fails_costs_neither_the_run_nor_other_metrics(further: None) -> None:
    log = drive_straight(5.0)
    failed = registry.measured("fails", log)
    assert not failed.valid
    assert re.fullmatch(r"the metric failed: IndexError: boom \(test_metric_registry\.py:\d+\)", failed.reason)
    assert registry.measured("number", log).reason == "metric 'number' gave float, expected Measured"
    assert registry.measured("held", log).valid


def test_a_column_that_its_owner_replaces_is_the_one_that_is_judged() -> None:
    """Also where Python gives the new one the place in memory of the old one."""
    log = log_of()
    columns, rows = log.columns, len(log.t)
    assert isinstance(columns, dict)
    whole = [np.full(2 * rows, float(k)) for k in range(30)]
    for k in range(30):
        del columns["v"]
        gc.collect()
        columns["v"] = whole[k][:rows]
        assert registry._unwritable(log)["v"][0] == float(k)
