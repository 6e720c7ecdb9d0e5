"""Small functions that effects share, and effects on lists of objects, by hand."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vehicle.model.effect_catalogue import find_effect
from vehicle.model.occlusion import hidden_share
from vehicle.model.perception_effects import Tracks
from vehicle.model.step_maths import DELAY_LINE, arrived, clip, delayed, lag, lag_end, limit_rate, recall, remember

LEFT = math.exp(-1.0)  # of the way, after one time constant


@pytest.mark.parametrize(("value", "expected"), [(-2.0, -1.0), (-1.0, -1.0), (0.5, 0.5), (3.0, 3.0), (3.5, 3.0)])
def test_a_clipped_value(value: float, expected: float) -> None:
    assert clip(value, -1.0, 3.0) == expected


@pytest.mark.parametrize(
    ("y", "u", "tau", "dt", "end"),
    [(1.0, 3.0, 0.1, 0.1, 3.0 - 2.0 * LEFT), (1.0, 3.0, 0.0, 0.1, 3.0), (1.0, 3.0, -1.0, 0.1, 3.0),
     (1.0, 3.0, 0.1, 0.2, 3.0 - 2.0 * LEFT**2)],
)  # fmt: skip
def test_the_end_of_a_lag(y: float, u: float, tau: float, dt: float, end: float) -> None:
    assert lag_end(y, u, tau, dt) == pytest.approx(end, rel=1e-12)


@pytest.mark.parametrize("beta", [0.5, 2.0])
def test_a_lag_answers_a_ramp_as_the_textbook_does(beta: float) -> None:
    """y = s + k (t - tau) + (y0 - s + k tau) exp(-t/tau); its mean is the integral over the step."""
    tau, dt, y0, start, end_of_input = 0.2, 0.2 * beta, 1.0, 4.0, 2.0
    k, gone = (end_of_input - start) / dt, 1.0 - math.exp(-beta)
    end = start + k * (dt - tau) + (y0 - start + k * tau) * (1.0 - gone)
    mean = start + k * (0.5 * dt - tau) + (y0 - start + k * tau) * gone * tau / dt
    assert lag(y0, 3.0, 1.0, tau, dt) == pytest.approx((mean, end), rel=1e-12)


@pytest.mark.parametrize(
    ("y", "u", "lead", "limit", "expected"),
    [
        (0.0, 2.0, 0.0, 10.0, (0.5, 1.0)),
        (0.0, -2.0, 0.0, 10.0, (-0.5, -1.0)),
        (3.0, 2.0, 0.0, 10.0, (2.5, 2.0)),  # just within reach: the whole step on the way
        (0.0, 0.5, 0.0, 10.0, (0.375, 0.5)),
        (1.0, 0.5, 0.0, 10.0, (0.625, 0.5)),
        (0.0, 0.5, -0.25, 10.0, (0.5, 0.75)),
        (0.0, 0.5, -1.0, 10.0, (0.5, 1.0)),  # its end is out of reach
        (2.0, 2.0, 0.0, 0.0, (2.0, 2.0)),
    ],
)
def test_a_limited_rate(y: float, u: float, lead: float, limit: float, expected: tuple[float, float]) -> None:
    assert limit_rate(y, u, lead, limit, 0.1) == pytest.approx(expected, rel=1e-12)


def delay_line(before: float) -> SimpleNamespace:
    rings = {name: np.zeros(DELAY_LINE) for name in ("ring", "leads", "ends", "spans")}
    return SimpleNamespace(head=0.0, tail=0.0, before=before, **rings)


@pytest.mark.parametrize(
    ("delay", "means", "leads", "arrivals"),
    [
        # 7 before the log, then 1, 3 and 5 for 0.1 s each
        (0.1, (7.0, 1.0, 3.0), (0.0, 0.0, 0.0), (1.0, 1.0, 3.0)),
        (0.05, (4.0, 2.0, 4.0), (3.0, -1.0, -1.0), (1.0, 3.0, 5.0)),
        (0.125, (7.0, 2.5, 2.5), (0.0, 4.5, -1.5), (1.0, 1.0, 3.0)),
        (0.0, (1.0, 3.0, 5.0), (0.0, 0.0, 0.0), (1.0, 3.0, 5.0)),
    ],
)  # fmt: skip
def test_a_delayed_command_that_is_held(
    delay: float, means: tuple[float, ...], leads: tuple[float, ...], arrivals: tuple[float, ...]
) -> None:
    m, found, came = delay_line(7.0), [], []
    for k, u in enumerate((1.0, 3.0, 5.0)):
        found.append(delayed(m, u, 0.0, delay, 0.1 * k, 0.1))
        came.append(arrived(m, delay, 0.1 * k, 0.1))
    assert [mean for mean, _ in found] == pytest.approx(means)
    assert [lead for _, lead in found] == pytest.approx(leads, abs=1e-12)
    if delay in (0.05, 0.0):
        assert came == list(arrivals)
    else:
        assert came[1:] == list(arrivals[1:])  # of the first step nothing has arrived


def test_a_delayed_ramp_stays_one() -> None:
    """u = 10 t from t = 0, a twentieth of a second late: 10 (t - 0.05), in the mean of 0.1 s to 0.2 s that is 1."""
    m = delay_line(0.0)
    for k in range(3):
        mean, lead = delayed(m, 1.0 * k + 0.5, -0.5, 0.05, 0.1 * k, 0.1)
        if k == 0:
            assert (mean, lead) == pytest.approx((0.125, -0.125))  # 0 for half of the step, then up to 0.5
        else:
            assert (mean, lead) == pytest.approx((k, -0.5))


def test_a_delay_over_steps_of_different_lengths() -> None:
    m = delay_line(0.0)
    delayed(m, 1.0, 0.0, 0.2, 0.0, 0.1)
    delayed(m, 2.0, 0.0, 0.2, 0.1, 0.3)
    mean, lead = delayed(m, 9.0, 0.0, 0.2, 0.4, 0.1)  # what was from 0.2 to 0.3 s
    assert (mean, lead) == pytest.approx((2.0, 0.0))


@pytest.mark.parametrize(
    ("asked", "expected"),
    [(-1.0, (0, 1, 0.0)), (0.0, (0, 1, 0.0)), (0.25, (0, 1, 0.25)), (1.0, (1, 2, 0.0)), (2.0, (1, 2, 0.5)),
     (3.0, (2, 2, 0.0)), (9.0, (2, 2, 0.0))],
)  # fmt: skip
def test_what_is_recalled_lies_between_two_stamps(asked: float, expected: tuple[int, int, float]) -> None:
    m = SimpleNamespace(head=0.0, tail=0.0, times=np.zeros(DELAY_LINE))
    assert [remember(m, t) for t in (0.0, 1.0, 3.0)] == [0, 1, 2]
    assert recall(m, asked) == pytest.approx(expected)


def test_a_record_that_is_full_forgets_its_oldest_place() -> None:
    m = SimpleNamespace(head=0.0, tail=0.0, times=np.zeros(DELAY_LINE))
    assert [remember(m, float(k)) for k in range(DELAY_LINE + 2)][-2:] == [0, 1]
    assert recall(m, 0.0) == (2, 3, 0.0)  # stamps 2 and 3 are the oldest that are left


# --- objects around the ego


def objects(*rows: dict[str, float]) -> Tracks:
    """Boxes of 4 m by 2 m seen at t = 0 by an ego at (3, 4), unless a row says otherwise."""
    usual = dict.fromkeys((field.name for field in dataclasses.fields(Tracks)), 0.0)
    usual |= {"ego_x": 3.0, "ego_y": 4.0, "length": 4.0, "width": 2.0}
    columns = {name: np.array([{**usual, "object": n, **row}[name] for n, row in enumerate(rows)]) for name in usual}
    for name in ("object", "kind"):
        columns[name] = columns[name].astype(np.int64)
    return Tracks(**columns)


@pytest.mark.parametrize("turn", [0.0, 0.7, math.pi])
@pytest.mark.parametrize(
    ("boxes", "shares"),
    [
        # dx, dy, yaw, length, width as the ego sees them; one alone, one behind the other, side by side
        (((10.0, 0.0, 0.0, 4.0, 2.0),), (0.0,)),
        (((10.0, 0.0, 0.0, 4.0, 2.0), (20.0, 0.0, 0.0, 4.0, 2.0)), (0.0, 1.0)),
        (((10.0, 0.0, 0.0, 4.0, 2.0), (20.0, 8.0, 0.0, 4.0, 2.0)), (0.0, 0.0)),
        # plates across: the near one fills -0.1 to 0.1 in tangent; half of the far one, 0 to 0.2, lies behind it
        (((10.0, 0.0, 0.0, 0.0, 2.0), (20.0, 2.0, 0.0, 0.0, 4.0)), (0.0, math.atan(0.1) / math.atan(0.2))),
        # the ego stands in the first, which hides nothing
        (((1.5, 0.5, 0.0, 4.0, 2.0), (20.0, 0.0, 0.0, 4.0, 2.0)), (0.0, 0.0)),
        (((0.5, 1.5, math.pi / 2.0, 4.0, 2.0), (20.0, 0.0, 0.0, 4.0, 2.0)), (0.0, 0.0)),
    ],
)  # fmt: skip
def test_what_hides_what(boxes: tuple[tuple[float, ...], ...], shares: tuple[float, ...], turn: float) -> None:
    c, s = math.cos(turn), math.sin(turn)
    tracks = objects(*({"x": 3.0 + c * dx - s * dy, "y": 4.0 + s * dx + c * dy, "yaw": yaw + turn, "length": length,
                        "width": width} for dx, dy, yaw, length, width in boxes))  # fmt: skip
    assert hidden_share(tracks) == pytest.approx(np.array(shares), abs=1.0 / 64.0)


def test_what_is_there_at_another_time_hides_nothing() -> None:
    tracks = objects({"x": 13.0, "y": 4.0}, {"x": 23.0, "y": 4.0, "t": 1.0})
    assert hidden_share(tracks).tolist() == [0.0, 0.0]


def seen(name: str, tracks: Tracks, **p: Any) -> Tracks:
    return find_effect(name).function(tracks, SimpleNamespace(**p), np.random.default_rng(0))


def test_objects_beyond_the_range_are_not_seen() -> None:
    tracks = objects({"x": 8.0, "y": 4.0}, {"x": 3.0, "y": 9.001}, {"x": -2.0, "y": 4.0})
    assert seen("detection_range", tracks, R=5.0).object.tolist() == [0, 2]


def test_sizes_and_headings_are_seen_wrong() -> None:
    tracks = objects({"yaw": 0.5})
    sized = seen("detection_size", tracks, length_ratio=1.5, width_ratio=0.5)
    assert (sized.length[0], sized.width[0]) == (6.0, 1.0)
    assert seen("detection_yaw", tracks, b=0.25).yaw[0] == 0.75


@pytest.mark.parametrize(("share", "left"), [(1.0, [0, 1]), (0.99, [0])])
def test_objects_that_are_hidden_are_not_seen(share: float, left: list[int]) -> None:
    tracks = objects({"x": 13.0, "y": 4.0}, {"x": 23.0, "y": 4.0})
    assert seen("detection_occlusion", tracks, share=share, lidar=1.0).object.tolist() == left
    assert seen("detection_occlusion", tracks, share=share, lidar=0.0) is tracks


@pytest.mark.parametrize(
    ("p", "left"),
    [
        ({"rate": 0.0, "slope": 0.0, "pedestrian": 0.0, "bicycle": 0.0}, [0, 1, 2]),
        ({"rate": 1.0, "slope": 0.0, "pedestrian": 0.0, "bicycle": 0.0}, []),
        ({"rate": 0.0, "slope": 0.1, "pedestrian": 0.0, "bicycle": 0.0}, [0, 2]),  # 10 m away: always
        ({"rate": -2.0, "slope": 0.0, "pedestrian": 3.0, "bicycle": 0.0}, [0, 1]),
        ({"rate": -2.0, "slope": 0.0, "pedestrian": 0.0, "bicycle": 3.0}, [0, 1, 2]),
    ],
)
def test_objects_are_missed_by_distance_and_class(p: dict[str, float], left: list[int]) -> None:
    from vehicle.messages import OBJECT_KINDS

    tracks = objects({"x": 3.0, "y": 4.0}, {"x": 13.0, "y": 4.0},
                     {"x": 3.0, "y": 4.0, "kind": OBJECT_KINDS.index("pedestrian")})  # fmt: skip
    assert seen("detection_misses", tracks, **p).object.tolist() == left


def test_late_objects_are_where_they_were() -> None:
    """2 m/s along x; the heading goes on over half a turn; before it was first there it is not shown."""
    rows = [{"t": t, "x": 2.0 * t, "yaw": yaw, "object": 4} for t, yaw in ((0.0, 3.0), (1.0, 3.2 - 2.0 * math.pi))]
    late = seen("detection_latency", objects(*rows, {"t": 1.0, "x": 9.0, "object": 5}), T=0.5)
    assert late.object.tolist() == [4]
    assert (late.t[0], late.x[0], late.yaw[0]) == pytest.approx((1.0, 1.0, 3.1))


def test_false_objects_are_people_near_the_ego() -> None:
    rows = [{"t": 0.1 * k, "x": 100.0, "y": 100.0} for k in range(11)]
    shown = seen("detection_false", objects(*rows), rate=200.0)
    new = shown.object == -1
    assert 140 < new.sum() < 260  # 200 within 1 s, standard deviation 14
    away = np.hypot(shown.x[new] - 3.0, shown.y[new] - 4.0)
    assert away.max() <= 50.0
    assert 0.5 < (away > 25.0).mean() < 0.95  # evenly over a disc: three quarters beyond half its radius
    assert {shown.length[new].max(), shown.width[new].min()} == {0.6}
    assert (np.diff(shown.t) >= 0.0).all()
    assert len(seen("detection_false", objects(*rows).rows(np.zeros(0, dtype=np.int64)), rate=200.0).t) == 0


def test_false_objects_appear_at_each_stamp_alike() -> None:
    """Of 10,000 at two stamps half are at each; 5 standard deviations are 0.025."""
    shown = seen("detection_false", objects({"t": 0.0}, {"t": 10.0}), rate=1000.0)
    assert (shown.t[shown.object == -1] == 0.0).mean() == pytest.approx(0.5, abs=0.025)
