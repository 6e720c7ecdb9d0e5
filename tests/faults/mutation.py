"""Small mutations of a stack's parts, as data: what is changed, where, and which gate of which scenario should see it.

A fault is a table of `faults.toml`. `where` names a function, constant or property as the part that uses it knows it
("ads.control.steering.steer_law"); one of these says what becomes of it:

    value = X               a constant is X
    returns = X             a function always returns X ("none", [] and numbers)
    late = N                a function returns what it returned N calls ago
    swap = [i, j]           two of the things, or columns, that a function returns change places
    returns_argument = K    a function returns its argument K as it is
    result = K              number, column K, or field "K" of what a function returns: times, plus or set
    argument = K            the same for its argument K (without self)
    without = "NET.NAME"    a transition is missing in the Petri nets that are argument K
"""

from __future__ import annotations

import dataclasses
import functools
import importlib
import tomllib
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from pytest_dvp.drive.result import RunResult
from pytest_dvp.drive.run import run
from pytest_dvp.verdicts.judging import Verdict
from scenarios import path

HERE = Path(__file__).parent
LONGEST = 130.0  # s simulated; the longest scenario takes 116 s


@dataclasses.dataclass(frozen=True)
class Fault:
    """One mutation, and the gate of the scenario that sees it; `missed` says why none does."""

    name: str
    part: str
    where: str
    scenario: str
    gate: str
    change: dict[str, Any]
    missed: str = ""


def faults() -> list[Fault]:
    """All of faults.toml, in order."""
    known = {field.name for field in dataclasses.fields(Fault)}
    rows = tomllib.loads((HERE / "faults.toml").read_text())["fault"]
    return [
        Fault(**{k: v for k, v in row.items() if k in known}, change={k: v for k, v in row.items() if k not in known})
        for row in rows
    ]


def failed(scenario: str, seed: int) -> list[Verdict]:
    """Verdicts other than PASS of one run of a scenario that ships, under the reference stack's bounds (`gates/`)."""
    return not_passed(drive(scenario, seed, HERE / "gates" / f"{scenario}.gates.toml"))


def drive(scenario: str, seed: int, gates: Path | None = None) -> RunResult:
    """One run of a scenario that ships, under `gates` or those that ship with it."""
    file = path(f"{scenario}.xosc")
    return run(file, seed=seed, gates=gates, rootdir=file.parent, duration=LONGEST)


def not_passed(result: RunResult) -> list[Verdict]:
    """Verdicts other than PASS."""
    return [verdict for verdict in result.verdicts if verdict.status != "PASS"]


@contextmanager
def seeded(fault: Fault) -> Iterator[None]:
    """The fault is in the stack while this lasts."""
    owner, name = place(fault.where)
    raw = vars(owner)[name]
    setattr(owner, name, _mutant(raw, fault.change))
    try:
        yield
    finally:
        setattr(owner, name, raw)


def place(where: str) -> tuple[Any, str]:
    """Module or class that holds what `where` names, and its name there. Raises LookupError if it holds none."""
    parts = where.split(".")
    for k in range(len(parts) - 1, 0, -1):
        try:
            owner = importlib.import_module(".".join(parts[:k]))
        except ModuleNotFoundError:
            continue
        for part in parts[k:-1]:
            owner = vars(owner)[part]
        if parts[-1] not in vars(owner):
            break
        return owner, parts[-1]
    raise LookupError(where)


def _mutant(raw: Any, change: dict[str, Any]) -> Any:
    if "value" in change:
        return change["value"]
    if isinstance(raw, property):
        assert raw.fget is not None
        return property(_function(raw.fget, change))
    if isinstance(raw, staticmethod):
        return staticmethod(_function(raw.__func__, change))
    return _function(raw, change)


def _without(nets: tuple[Any, ...], transition: str) -> tuple[Any, ...]:
    of, _, name = transition.partition(".")
    assert any(net.name == of and name in {t.name for t in net.transitions} for net in nets), transition
    less = [tuple(t for t in net.transitions if (net.name, t.name) != (of, name)) for net in nets]
    return tuple(dataclasses.replace(net, transitions=left) for net, left in zip(nets, less, strict=True))


def _function(raw: Callable[..., Any], change: dict[str, Any]) -> Callable[..., Any]:
    earlier: deque[Any] = deque(maxlen=change.get("late", 0) + 1)
    is_method = "self" in getattr(raw, "__code__", getattr(raw, "py_func", raw).__code__).co_varnames[:1]

    @functools.wraps(getattr(raw, "py_func", raw))
    def mutant(*given: Any, **named: Any) -> Any:
        arguments = list(given)
        if "argument" in change:
            k = change["argument"] + is_method
            nets = change.get("without")
            arguments[k] = _without(arguments[k], nets) if nets else _changed(arguments[k], None, change)
        result = raw(*arguments, **named)
        if "returns" in change:
            return {"none": None, "[]": ()}.get(str(change["returns"]), change["returns"])
        if "swap" in change:
            return _swapped(result, *change["swap"])
        if "returns_argument" in change:
            return arguments[change["returns_argument"] + is_method]
        if "late" in change:
            earlier.append(result)
            return earlier[0]
        return _changed(result, change["result"], change) if "result" in change else result

    return mutant


def _swapped(result: Any, i: int, j: int) -> Any:
    if isinstance(result, np.ndarray):
        out = result.copy()
        out[:, [i, j]] = result[:, [j, i]]
        return out
    out = list(result)
    out[i], out[j] = out[j], out[i]
    return tuple(out)


def _changed(value: Any, at: Any, change: dict[str, Any]) -> Any:
    """A copy of `value` of which the number, column or field `at` is another; "" is the whole."""
    if value is None:
        return None
    if at in (None, ""):
        return _number(value, change)
    if isinstance(value, np.ndarray):
        out = value.copy()
        out[..., at] = _number(out[..., at], change)
        return out
    if hasattr(value, "_replace"):
        name = at if isinstance(at, str) else value._fields[at]
        return value._replace(**{name: _number(getattr(value, name), change)})
    if isinstance(value, msgspec.Struct):
        return msgspec.structs.replace(value, **{at: _number(getattr(value, at), change)})
    if isinstance(value, tuple | list) and isinstance(at, str):
        return type(value)(_changed(entry, at, change) for entry in value)
    out = list(value)
    out[at] = _number(out[at], change)
    return tuple(out)


def _number(value: Any, change: dict[str, Any]) -> Any:
    if "set" in change:
        return value * 0 + change["set"] if isinstance(value, np.ndarray) else change["set"]
    return value * change.get("times", 1.0) + change.get("plus", 0.0)
