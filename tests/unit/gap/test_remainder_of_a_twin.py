"""What is written of a twin's remainder, and which groups of drives it is measured on; and who drives in circles."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import pytest

from pytest_dvp.gap.diagnose import fitted_twin as module
from pytest_dvp.gap.diagnose.fitted_twin import with_remainder
from pytest_dvp.gap.manoeuvres.catalogue import MANOEUVRES
from vehicle.model.model_file import parse_model
from vehicle.model.remainder_shape import RemainderShape

MODEL = parse_model("[model]\nname = 'car'\n[parameters]\nwheelbase = 2.5\n")


def a_drive(name: str, hills: Any = None) -> Any:
    """A drive that says which values it was asked for, and tells `hills` on what road it is judged."""
    return SimpleNamespace(
        hills=lambda values: (name, "hills", values), on_hills=[].append if hills is None else hills.append,
        slopes=0.0 if hills is None else 0.05,
        log=SimpleNamespace(t=f"t of {name}"), segments=SimpleNamespace(starts=f"starts of {name}"),
        left=lambda values: (name, "left", values), reckoned=lambda values: (name, "reckoned", values),
        residuals=lambda values: SimpleNamespace(values=(name, values)),
    )  # fmt: skip


@pytest.mark.parametrize("remainder", [{}, {"v": {"cruise": 0.1}}])
def test_a_remainder_is_measured_on_the_drives_fitted_on_and_on_those_apart(
    remainder: dict[str, dict[str, float]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each with its own values: those refitted where a drive was held out. A part of a drive is no drive of its own,
    and without a remainder there is nothing to say of its memory."""
    asked: dict[str, Any] = {}

    def keep(name: str, answer: Any) -> Any:
        def take(first: Any, *more: Any) -> Any:
            asked[name] = list(first)
            return answer

        return take

    memory, wanders = {"v": {"cruise": 2.0}}, {"yaw": {"cruise": 0.01}}
    monkeypatch.setattr(module, "measured_remainder", keep("remainder", remainder))
    monkeypatch.setattr(module, "measured_memory", keep("memory", memory))
    monkeypatch.setattr(module, "measured_steps", keep("steps", wanders))
    monkeypatch.setattr(module, "refit_on_fold", lambda search, fold, final: SimpleNamespace(values="refitted"))
    monkeypatch.setattr(module, "told_spread", keep("hills", 0.0712345))
    roads: list[float] = []
    search: Any = SimpleNamespace(target=SimpleNamespace(experiments=[a_drive("a", roads)]))
    apart = [a_drive("b", roads), a_drive("c", roads)]
    folds: Any = [SimpleNamespace(fitted=None, judge=SimpleNamespace(experiments=apart)),
                  SimpleNamespace(fitted="half", judge=SimpleNamespace(experiments=[a_drive("d")]))]  # fmt: skip
    old = dataclasses.replace(MODEL, remainder_shape=RemainderShape(wanders={"along": {"cruise": 9.0}}))
    found = with_remainder(old, search, SimpleNamespace(values="fitted"), folds)  # type: ignore[arg-type]
    groups = [[("a", "fitted")], [("b", "refitted"), ("c", "refitted")]]
    assert asked["remainder"] == [[(name, "left", values) for name, values in group] for group in groups]
    assert asked["hills"] == [(name, "hills", values) for group in groups for name, values in group]
    assert roads == [0.0712] * 3
    assert found.remainder == remainder
    if remainder:
        assert asked["steps"] == [[(name, "reckoned", values) for name, values in group] for group in groups]
        each = [*groups[0], *groups[1]]
        assert asked["memory"] == [(f"t of {name}", (name, values), f"starts of {name}") for name, values in each]
        assert found.remainder_shape == RemainderShape(memory=memory, wanders=wanders, slopes=0.0712)
    else:
        assert found.remainder_shape == RemainderShape(slopes=0.0712)
        assert set(asked) == {"hills", "remainder"}


def test_without_drives_apart_each_fitted_one_is_a_group_and_all_together(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[Any] = []
    monkeypatch.setattr(module, "measured_remainder", lambda groups: asked.append([list(g) for g in groups]) or {})
    search: Any = SimpleNamespace(target=SimpleNamespace(experiments=[a_drive("a"), a_drive("b")]))
    parts: Any = [SimpleNamespace(fitted="half", judge=SimpleNamespace(experiments=[a_drive("d")]))]
    with_remainder(MODEL, search, SimpleNamespace(values="fitted"), parts)  # type: ignore[arg-type]
    one, other = ("a", "left", "fitted"), ("b", "left", "fitted")
    assert asked == [[[one], [other], [one, other]]]


def test_circles_need_ground_to_drive_round_about_and_no_other_manoeuvre_does() -> None:
    assert {m.name for m in MANOEUVRES if m.round_about} == {"circles_left", "circles_both", "figure_eight"}
