"""The kernel as plain Python, for all tests of its equations."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from plain_effects import Applied

from vehicle.model import kernel
from vehicle.model.effect import SLOTS

Plain = Callable[..., Any]


@pytest.fixture
def plain(monkeypatch: pytest.MonkeyPatch) -> Plain:
    """plain(name, *effects): a function of the kernel that runs as Python, and so does all that it calls."""

    def get(name: str, *effects: Applied) -> Any:
        def slot(index: int, record: Any, *_: Any) -> None:
            for each in effects:
                if each.slot == SLOTS[index]:
                    each(record[0])

        monkeypatch.setattr(kernel, "_slot", slot)
        return getattr(kernel, name)

    for name, function in list(vars(kernel).items()):
        if hasattr(function, "py_func"):
            monkeypatch.setattr(kernel, name, function.py_func)
    return get
