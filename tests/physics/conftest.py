"""The kernel as plain Python, for all tests of its equations."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from plain_effects import Applied

from vehicle.model import air_forces, imposed_speed, kernel, road_hold
from vehicle.model.effect import SLOTS
from vehicle.model.kernel import SHAPES, TAKES
from vehicle.model.kernel_layout import ROAD_HOLDS

Plain = Callable[..., Any]


@pytest.fixture
def plain(monkeypatch: pytest.MonkeyPatch) -> Plain:
    """plain(name, *effects): a function of the kernel that runs as Python, and so does all that it calls."""

    def get(name: str, *effects: Applied) -> Any:
        def slot(index: int, record: Any, *_: Any) -> None:
            for each in effects:
                if index in (SHAPES, TAKES):
                    called = each.slot == "body" and (each.order <= ROAD_HOLDS) == (index == SHAPES)
                else:
                    called = each.slot == SLOTS[index]
                if called:
                    each(record[0])

        monkeypatch.setattr(kernel, "_slot", slot)
        return getattr(kernel, name)

    for module in (road_hold, imposed_speed, air_forces, kernel):
        for name, function in list(vars(module).items()):
            if hasattr(function, "py_func"):
                monkeypatch.setattr(module, name, function.py_func)
    return get
