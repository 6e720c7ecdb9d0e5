"""The figures of localization and perception measure what they say: a spoilt part gets bad ones."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest

from ads.parameters import Parameters
from ads.perception.pipeline import TrackingPerception
from scripts import ads_figures_localization as localization
from scripts import ads_figures_perception as perception

BOX = np.array([10.0, 0.0, 0.75, 0.0, 4.0, 2.0, 1.5, 0.0, 0.0])


def moved(x: float, y: float) -> np.ndarray:
    return BOX + np.array([x, y, 0, 0, 0, 0, 0, 0, 0])


class Shifted(TrackingPerception):
    """Reports everything 0.6 m to the left."""

    def update(self, observation, estimate):
        return tuple(msgspec.structs.replace(d, y=d.y + 0.6) for d in super().update(observation, estimate))


class Blind(TrackingPerception):
    def update(self, observation, estimate):
        return ()


class TestPerception:
    @pytest.mark.parametrize(
        ("other", "free"),
        [((-4.5, 0.0), 0.0), ((6.0, 0.0), 1.0), ((-5.0, 5.0), 1.0), ((-5.0, 1.0), 0.5)],
        ids=["hidden", "behind it", "beside", "half hidden"],
    )
    def test_what_a_nearer_box_hides_is_not_in_view(self, other, free):
        """Seen from the origin the box is 8 m away and 2 m wide; the other, 4 m by 2 m, stands where told from it."""
        small = moved(*other)
        assert perception.free_share(np.array([BOX, small]), 0, 0.0, 0.0) == pytest.approx(free, abs=0.12)

    def test_nobody_touches_anybody_while_a_drive_lasts(self):
        users = perception.traffic(3)
        for t in np.arange(0.0, perception.DURATION, 0.5):
            boxes = users.at(t)
            for i, a in enumerate(boxes):
                for b in boxes[:i]:
                    assert math.hypot(*(a[:2] - b[:2])) > 0.5 * (a[5] + b[5])

    @pytest.mark.parametrize(
        ("part", "error"), [(TrackingPerception, 0.25), pytest.param(Shifted, 0.8, marks=pytest.mark.nightly)]
    )
    def test_an_error_of_the_detections_is_in_the_figure(self, part, error):
        rows = perception.drive(1, Parameters(), make=part).rows
        rmse = math.sqrt(np.mean(rows[np.isfinite(rows[:, 2]), 2] ** 2))
        assert error - 0.25 < rmse < error
        assert len(rows) > 200

    @pytest.mark.nightly
    def test_who_sees_nothing_has_no_recall(self):
        score = perception.drive(1, Parameters(), make=Blind)
        assert not np.isfinite(score.rows[:, 2]).any()


class TestLocalization:
    def test_every_figure_has_name_goal_and_verdict(self):
        found = localization.figures(seeds=2, drives=1)
        assert len({f["name"] for f in found}) == len(found) == 13  # three of them with an IMU mounted elsewhere
        assert all(set(f) == {"name", "found", "goal", "met"} for f in found)
        assert all(isinstance(f["met"], bool) for f in found)

    def test_an_antenna_that_is_elsewhere_shows_in_the_nees(self):
        truth = localization.drive(12.0)
        wrong = truth._replace(car=msgspec.structs.replace(truth.car, gnss_x=truth.car.gnss_x + 0.5))
        honest = localization.nees(truth, 10, (11.0,)).mean()
        assert honest < 7.0 < localization.nees(wrong, 10, (11.0,)).mean()
