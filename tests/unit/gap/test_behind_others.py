"""What a car loses behind others that its twin sees: rows that this file draws."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.perception import diagnose_perception as module
from pytest_dvp.gap.perception.behind_others import GAIN, LEAST_ROWS, LIDAR, SHARE, Behind, lost_behind, needed_behind
from pytest_dvp.gap.perception.perceived_values import Perceived
from vehicle.model.model_file import parse_model

BARE = parse_model("[model]\nname = 'car'\n[parameters]\nwheelbase = 2.5\n")
BOTH, CAMERA = (BARE.with_effect("detection_occlusion", {"share": 0.4, "lidar": lidar}) for lidar in (1.0, 0.0))

YAW = ("detection_yaw", "b")


def drive(border: float = 1.0, left: float = 0.0, seed: int = 1, clear: float = 1.0, n: int = 400) -> Behind:
    """What is hidden up to 0.6 is seen, of the rest less and less; beyond `border` a part `left` of that."""
    rng = np.random.default_rng(seed)
    share = rng.uniform(0.1, 1.0, n)
    usual = np.clip(1.0 - 2.2 * (share - 0.6), 0.02, 0.97)
    seen = rng.random(n) < clear * usual * np.where(share > border, left, 1.0)
    return Behind(share, seen, np.arange(n) // 5, clear)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("border", [0.25, 0.4, 0.55])
@pytest.mark.parametrize(("left", "lidar"), [(0.02, 1.0), (0.45, 0.0)])
def test_the_border_is_found_and_whether_the_lidar_still_sees(
    border: float, left: float, lidar: float, seed: int
) -> None:
    found = lost_behind(drive(border, left, seed=10 + seed), drive(seed=seed))
    assert found is not None
    assert found.gain > GAIN
    assert found.share[0] == pytest.approx(border, abs=0.11)
    assert found.share[1] <= border <= found.share[2]
    assert found.lidar[0] == lidar
    assert found.lidar[1] <= lidar <= found.lidar[2]


@pytest.mark.parametrize("clear", [1.0, 0.5])
def test_two_that_lose_the_same_show_no_border(clear: float) -> None:
    """Nor does a car that misses half of everything; by chance one of twenty may."""
    gains = [lost_behind(drive(seed=20 + k, clear=clear), drive(seed=k)) for k in range(40)]
    assert sum(one is not None and one.gain >= GAIN for one in gains) <= 2


def test_a_model_without_the_effect_gets_it() -> None:
    lost, lacks = needed_behind(drive(0.3, seed=2), drive(), BARE.effects)
    assert lacks
    assert lost is not None
    assert lost.share[0] == pytest.approx(0.3, abs=0.11)
    same, lacks = needed_behind(drive(seed=2), drive(), BARE.effects)
    assert (same is not None, lacks) == (True, False)


@pytest.mark.parametrize(("model", "left"), [(BOTH, 0.0), (CAMERA, 0.4)])
def test_a_model_that_loses_the_same_keeps_what_it_has(model: Any, left: float) -> None:
    has = next(a.values for a in model.effects)
    lost, lacks = needed_behind(drive(0.4, left, seed=2), drive(0.4, left), model.effects)
    assert lost is not None
    assert (lost.share[0], lost.lidar[0], lacks) == (has["share"], has["lidar"], False)


def test_a_model_that_loses_too_much_lets_its_lidar_see_again_and_then_its_camera() -> None:
    lost, lacks = needed_behind(drive(0.4, 0.5, seed=2), drive(0.4, 0.0), BOTH.effects)
    assert lost is not None
    assert (lost.share[0], lost.lidar[0], lacks) == (0.4, 0.0, True)
    lost, lacks = needed_behind(drive(seed=2), drive(0.4, 0.3), CAMERA.effects)
    assert lost is not None
    assert (lost.share[0], lost.lidar[0], lacks) == (1.0, 1.0, True)


def test_a_model_that_loses_too_little_gets_the_smaller_border() -> None:
    lost, lacks = needed_behind(drive(0.2, seed=2), drive(0.4, 0.4), CAMERA.effects)
    assert lost is not None
    assert lacks
    assert lost.share[0] == pytest.approx(0.2, abs=0.11)
    assert lost.lidar[0] == 1.0


def diagnosed(monkeypatch: pytest.MonkeyPatch, car: Perceived, twin: Perceived, model: Any) -> dict[str, Any]:
    log, run = (SimpleNamespace(meta={"stage": ""}), SimpleNamespace(meta={"stage": "dt"}))
    monkeypatch.setattr(module, "perceived_in", lambda one: car if one is log else twin)
    return {e.name: e for e in module.diagnose_perception(log, model, twin=run)}  # type: ignore[arg-type]


def perceived(behind: Behind, turn: float = 0.0) -> Perceived:
    return Perceived({YAW: (turn, turn - 0.01, turn + 0.01)}, {YAW[0]: 5.0, SHARE[0]: 5.0}, {}, behind=behind)


def test_a_diagnosis_names_it_with_both_values_and_waits_for_wrong_boxes(monkeypatch: pytest.MonkeyPatch) -> None:
    found = diagnosed(monkeypatch, perceived(drive(0.3, 0.45, seed=2)), perceived(drive()), BARE)
    assert set(found) == {SHARE[0]}
    assert found[SHARE[0]].standing == "confirmed"
    assert found[SHARE[0]].action == "add"
    assert found[SHARE[0]].parameters["share"].value == pytest.approx(0.3, abs=0.11)
    assert found[SHARE[0]].parameters["lidar"].value == 0.0
    turned = diagnosed(monkeypatch, perceived(drive(0.3, 0.45, seed=2), turn=0.2), perceived(drive()), BARE)
    assert {name: e.standing for name, e in turned.items()} == {YAW[0]: "confirmed", SHARE[0]: "provisional"}


def test_a_diagnosis_says_nothing_of_a_model_that_loses_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    assert not diagnosed(monkeypatch, perceived(drive(0.4, 0.4, seed=2)), perceived(drive(0.4, 0.4)), CAMERA)
    found = diagnosed(monkeypatch, perceived(drive(seed=2)), perceived(drive(0.4, 0.3)), CAMERA)
    assert found[SHARE[0]].action == "remove"


def test_few_rows_tell_nothing() -> None:
    few = drive(n=LEAST_ROWS - 1)
    assert lost_behind(few, drive()) is None
    assert lost_behind(drive(), few) is None
    assert needed_behind(few, drive(), CAMERA.effects) == (None, False)
    assert lost_behind(drive(n=LEAST_ROWS), drive()) is not None


def test_the_keys_are_those_of_the_effect() -> None:
    assert {SHARE[1], LIDAR[1]} == {key.name for key in BOTH.effects[0].effect.parameters}
