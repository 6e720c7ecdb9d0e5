"""What a value is unsure by where the data cannot tell which of some effects is there."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from pytest_dvp.gap.diagnose import rival_values
from pytest_dvp.gap.diagnose.rival_values import with_rival_values

INERTIA, ROLL, K, TAU = ("yaw_inertia", "ratio"), ("roll", "gain"), ("understeer", "K"), ("roll_dynamics", "tau")
VALUES = {INERTIA: 0.69, ROLL: 0.12, K: 0.0015}
FIT = SimpleNamespace(
    coordinates=[SimpleNamespace(name=name, key=SimpleNamespace(minimum=0.0, maximum=0.85)) for name in VALUES]
)
SURE = {INERTIA: (0.66, 0.71), ROLL: (0.11, 0.13), K: (0.001, 0.002)}


@pytest.fixture
def search(monkeypatch: pytest.MonkeyPatch) -> Any:
    """In the place of the understeer a roll that lags, with another inertia beside it: 0.81 to 0.86, 0.85 at most."""
    told = SimpleNamespace(values={INERTIA: 0.84, ROLL: 0.121, TAU: 0.1})
    monkeypatch.setattr(rival_values, "as_told", lambda search, trial: trial)

    def in_place_of(final: Any, name: str, among: Any) -> list[Any]:
        assert (name, among) == ("understeer", ["roll_dynamics"])
        return [SimpleNamespace(names=("yaw_inertia", "roll", "roll_dynamics"), fit=told)]

    return SimpleNamespace(tried={"roll_dynamics": None, "understeer": None}, in_place_of=in_place_of, starts=())


def test_a_value_is_as_unsure_as_the_set_that_it_is_of(search: Any) -> None:
    final: Any = SimpleNamespace(names=("yaw_inertia", "roll", "understeer"), values=VALUES, fit=FIT)
    found = with_rival_values(search, final, SURE, {"understeer": ("roll_dynamics",), "roll": ()})
    assert found == {INERTIA: (0.66, 0.85), ROLL: (0.11, pytest.approx(0.131)), K: (0.001, 0.002)}
    assert SURE[INERTIA] == (0.66, 0.71)


@pytest.mark.parametrize("rivals", [{}, {"understeer": ("yaw_inertia", "mass")}, {"mass": ("roll_dynamics",)}])
def test_what_is_no_rival_of_the_set_changes_nothing(search: Any, rivals: dict[str, tuple[str, ...]]) -> None:
    """One that is in the set, that was not tried, or whose effect the set no longer has."""
    final: Any = SimpleNamespace(names=("yaw_inertia", "roll", "understeer"), values=VALUES, fit=FIT)
    assert with_rival_values(search, final, SURE, rivals) == SURE
