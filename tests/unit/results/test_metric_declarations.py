"""What each metric declares beside its number: direction, defaults, what it says of a recording, its best value."""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, Annotated, Any

import pytest

from pytest_dvp.metrics import Range, find_metric, known_metrics
from pytest_dvp.metrics.metric import REQUIRED, Measured, metric

if TYPE_CHECKING:
    from pytest_dvp.logs.log import Log

Speed = Annotated[float, Range(0.0, 60.0)]

AHEAD = {"reach": 20.0, "beside": 4.0, "within": 3.0}
TRACKS = {**AHEAD, "beyond": 0.0}
LESS_IS_BETTER: dict[str, dict[str, Any]] = {
    "accel_roughness": {"signal": "accel_cmd", "cutoff": 1.0},
    "collision": {},
    "completion_time": {},
    "creep": {"slow": 0.3, "least": 1.0},
    "events_fired": {"optional": ()},
    "lane_time_outside": {"width": math.nan},
    "lateral_rmse": {},
    "lateral_rmse_path": {},
    "max_acceleration": {"cutoff": 1.0},
    "max_deceleration": {"cutoff": 1.0},
    "max_jerk": {"cutoff": 1.0},
    "max_lateral_acceleration": {"cutoff": 1.0},
    "max_lateral_jerk": {"cutoff": 1.0},
    "max_steer_rate": {"cutoff": 5.0},
    "max_ttc_inverse": {"resolution": 0.01},
    "max_yaw_rate": {},
    "model_gain": {"model": REQUIRED, "signal": REQUIRED},
    "model_lag": {"model": REQUIRED, "signal": REQUIRED},
    "open_loop_error": {"model": REQUIRED, "signal": REQUIRED},
    "path_distance": {},
    "red_light": {},
    "required_deceleration": {"resolution": 0.1},
    "road_departure": {},
    "rss_violation": dict.fromkeys(
        ("response_time", "max_acceleration", "max_braking", "min_braking", "lateral_acceleration", "lateral_braking",
         "lateral_margin"), math.nan),
    "speed_excess": {},
    "start_up_delay": {"slow": 0.5},
    "steer_roughness": {"signal": "steer_cmd", "cutoff": 1.0},
    "stop_error": {},
    "stop_line": {},
    "tet": {"critical": 2.0},
}  # fmt: skip
LESS_IS_BETTER_IN_A_PLAYBACK_TOO: dict[str, dict[str, Any]] = {
    "command_age": {},
    "detection_error": AHEAD,
    "disordered_inputs": {},
    "false_tracks": TRACKS,
    "heading_error": {"statistic": "rms"},
    "identity_switches": TRACKS,
    "input_age": {"sensor": REQUIRED, "statistic": "greatest"},
    "kind_error": TRACKS,
    "lane_width_error": {},
    "localization_error": {"statistic": "rms"},
    "missed_objects": AHEAD,
    "repeated_commands": {"signal": "steer_cmd", "slow": 0.5},
    "replay_accel_error": {},
    "replay_steer_error": {},
    "speed_error": {"statistic": "rms"},
    "tick_time": {"statistic": "p99"},
    "track_coasting": TRACKS,
    "track_latency": {**TRACKS, "moving": 1.0},
    "track_position_error": TRACKS,
    "track_size_error": TRACKS,
    "track_speed_error": TRACKS,
    "track_yaw_error": TRACKS,
    "twin_chi2": {"signal": "yaw_rate", "regime": "worst", "least": 2.0},
    "twin_error": {"signal": "position"},
}
MORE_IS_BETTER: dict[str, dict[str, Any]] = {
    "detection_recall": TRACKS,
    "goal_reached": {},
    "min_distance": {},
    "min_distance_lateral": {},
    "min_distance_longitudinal": {},
    "mncc": {"signal": REQUIRED, "max_lag": 5.0},
    "model_mncc": {"model": REQUIRED, "signal": REQUIRED},
    "passing_clearance": {"faster": 1.0},
    "pet": {"longest": 10.0},
    "scenario_ended": {},
    "time_headway": {"slow": 0.5},
}
NEITHER: dict[str, dict[str, Any]] = {
    "bias": {"signal": REQUIRED, "max_lag": 5.0},
    "event_started": {"event": REQUIRED},  # one event must happen, another one must not
    "gain": {"signal": REQUIRED, "max_lag": 5.0},
    "lag": {"signal": REQUIRED, "max_lag": 5.0},
    "localization_nees": {},
    "nees": TRACKS,
    "nis": {"sensor": REQUIRED, "statistic": "mean"},
    "response_gain": {"command": "steer_cmd", "signal": "steer"},
    "response_lag": {"command": "steer_cmd", "signal": "steer"},
    "twin_gain": {"signal": "yaw_rate"},
}
DIRECTION: dict[str, bool | None] = {
    **dict.fromkeys((*LESS_IS_BETTER, *LESS_IS_BETTER_IN_A_PLAYBACK_TOO), True),
    **dict.fromkeys(MORE_IS_BETTER, False),
    **dict.fromkeys(NEITHER, None),
}
OPTIONS = LESS_IS_BETTER | LESS_IS_BETTER_IN_A_PLAYBACK_TOO | MORE_IS_BETTER | NEITHER
OF_THE_STACK_OR_THE_CAR = {*LESS_IS_BETTER_IN_A_PLAYBACK_TOO, "detection_recall", "localization_nees", "nees", "nis",
                           "response_gain", "response_lag", "twin_gain"}  # fmt: skip
BEST = {
    **dict.fromkeys(("gain", "mncc", "model_mncc", "nis", "response_gain", "twin_gain", "detection_recall"), 1.0),
    **dict.fromkeys(("localization_nees", "nees"), 2.0),  # a chi-squared of two degrees of freedom is 2 on average
}
OF_TWO_LOGS = {"bias", "gain", "lag", "mncc", "path_distance", "twin_chi2", "twin_error", "twin_gain"}
TEST_DID_NOT_TAKE_PLACE = {"events_fired", "goal_reached"}


@pytest.mark.parametrize("name", sorted(OPTIONS))
def test_a_metric_declares_what_its_meaning_asks_for(name: str) -> None:
    found = find_metric(name)
    assert found.bigger_is_worse is DIRECTION[name]
    assert found.open_loop is (name in OF_THE_STACK_OR_THE_CAR)
    assert found.ideal == BEST.get(name)
    assert found.logs == (2 if name in OF_TWO_LOGS else 1)
    assert found.miss == ("INCONCLUSIVE" if name in TEST_DID_NOT_TAKE_PLACE else "FAIL")
    assert found.scale == 1.0
    assert {key: str(value) for key, value in found.options.items()} == {
        key: str(value) for key, value in OPTIONS[name].items()
    }


def test_who_declares_nothing_gets_the_strict_defaults() -> None:
    """A broken bound is the stack's failure, a playback tells nothing of it, and one unit is a whole margin."""

    @metric(name="plain", unit="m", bigger_is_worse=True)
    def plain(log: object, /, *, far: float = 3.0) -> Measured:
        """Something."""
        return Measured(far)

    assert (plain.miss, plain.open_loop, plain.ideal, plain.scale) == ("FAIL", False, None, 1.0)
    assert (plain.note, plain.logs, dict(plain.options)) == ("", 1, {"far": 3.0})
    assert plain(None, far=2.0).value == 2.0


def test_a_number_alone_has_neither_time_nor_object_nor_course() -> None:
    found = Measured(1.5)
    assert (found.t, found.object, found.series, dict(found.extra), found.unit) == (None, "", None, {}, "")


def test_the_type_of_an_option_states_its_range() -> None:
    """What a type checker alone knows, as the log's type here, takes no range from the options."""

    def far(
        log: Log,
        *,
        speed: Speed = 1.0,
        after: Annotated[float, "s", Range(2.0)] = 3.0,
        until: Speed | None = None,
        foreign: Nowhere = 1.0,  # type: ignore[name-defined]  # noqa: F821
        broken: "Annotated[float, Range(1)" = 1.0,  # type: ignore  # noqa: F722
        plain: float = 1.0,
    ) -> Measured:
        """Something."""
        return Measured(speed)

    @functools.wraps(far)
    def wrapped(*logs: Any, **options: Any) -> Measured:
        return far(*logs, **options)

    stated = {"speed": Range(0.0, 60.0), "after": Range(2.0), "until": Range(0.0, 60.0)}
    for function in (far, wrapped):
        made = metric(name="far", unit="m", bigger_is_worse=True)(function)
        assert dict(made.ranges) == stated
        assert list(made.options) == ["speed", "after", "until", "foreign", "broken", "plain"]


def test_a_type_that_is_no_text_states_its_range_too() -> None:
    def far(log: object, *, speed: float = 1.0) -> Measured:
        """Something."""
        return Measured(speed)

    far.__annotations__["speed"] = Speed  # as in a module without `from __future__ import annotations`
    assert dict(metric(name="far", unit="m", bigger_is_worse=True)(far).ranges) == {"speed": Range(0.0, 60.0)}


@pytest.mark.parametrize("name", sorted(OPTIONS))
def test_each_number_that_a_metric_may_be_asked_with_has_a_range(name: str) -> None:
    found = known_metrics()[name]
    assert {key for key, default in found.options.items() if isinstance(default, float)} == set(found.ranges)
