"""A second opinion: which effect explains most by regression of measured derivatives, without any simulation.

Weaker than simulating, for noise is differentiated, but independent of the kernel, of its fits and of its search.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from pytest_dvp.gap.diagnose.regression_signals import STEERED, Signals, signals
from pytest_dvp.gap.diagnose.regressors import FORMS, Columns, Form, base
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray

if TYPE_CHECKING:
    from vehicle.model.vehicle_model import VehicleModel

_BLOCK = 5.0  # s
_FOLDS = 5  # usual for cross-validation: Hastie, Tibshirani, Friedman, The Elements of Statistical Learning, sec. 7.10
_WORTH = 0.05  # of max(1, chi^2/N left): a smaller gain names nothing
_PLAIN = 0.004  # of the score, a further unknown must bring
_LEAST_ROWS = 50  # 1 s at 50 Hz; chosen: fewer rows cannot judge some ten unknowns
_KEPT = 0.5  # of what an effect takes away: as much beside another one means that the two are no rivals
_CLEARLY = 1.25  # times what a named effect takes away: another one that takes away more speaks against it


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # a model of quite another car: no vote then
def votes(logs: Mapping[str, Log], model: VehicleModel) -> dict[str, Any]:
    """What equation-error regression would name: {"first": name or None, "ranking": [[name, score], ...],
    "not_judged": [names]}.

    score: share of the misfit (chi^2 - N over all equations) that the effect alone takes away on blocks of 5 s which it
    was not fitted on, less 0.004 for each further unknown; below 0 it makes things worse. One effect at a time: a car
    with two effects may get a third one's vote. Not judged are effects without such a form, those whose signals were
    not measured, and all of a model that has effects: the equations are those of an ideal car.

    Raises CompareError if a command that drives the model is not in a log.
    """
    from vehicle.model.effect_catalogue import catalogue

    tables = [_Table(signals(log, model)) for log in logs.values()]
    tables = [t for t in tables if len(t.s.rows) >= _LEAST_ROWS]
    names = [name for name, effect in catalogue().items() if effect.slot != "perception"]
    if not tables or model.effects:
        return {"first": None, "ranking": [], "not_judged": names}
    count = sum(t.count for t in tables)
    chi2 = sum(t.chi2 for t in tables)
    excess = max(chi2 - count, 1e-9 * count)
    scored = []
    for form in FORMS:
        gain = _gain(form, tables)
        if gain is not None and np.isfinite(gain[0] / excess):
            scored.append((gain[0] / excess - _PLAIN * (gain[1] - 1), form.name))
    scored.sort(key=lambda pair: (-pair[0], pair[1]))
    judged = {name for _, name in scored}
    first = None
    if scored and scored[0][0] * excess > _WORTH * max(float(count), chi2 - scored[0][0] * excess):
        first = scored[0][1]
    return {
        "first": first,
        "ranking": [[name, round(float(score), 4)] for score, name in scored],
        "not_judged": [name for name in names if name not in judged],
    }


@dataclasses.dataclass(frozen=True, slots=True)
class Opinion:
    """What the second engine says of a named effect: it agrees, it would rather name `instead`, or it cannot tell."""

    says: Literal["agrees", "disagrees", "silent"] = "silent"
    instead: str = ""


@np.errstate(over="ignore", invalid="ignore", divide="ignore")
def opinions(logs: Mapping[str, Log], model: VehicleModel, named: Mapping[str, Mapping[str, float]]
             ) -> dict[str, Opinion]:  # fmt: skip
    """What equation-error regression says of each named effect (its values by key) beside all the others.

    Silent where it has no equation for the effect, where its signals were not measured, where noise hides all that
    effects would do to a derivative, of steering where the model's tyres slip, and of a model that has effects: the
    equations are those of an ideal car. It disagrees where another effect, not named, takes clearly more off blocks of
    5 s that it was not fitted on.

    Raises CompareError if a command that drives the model is not in a log.
    """
    silent = dict.fromkeys(named, Opinion())
    tables = [_Table(signals(log, model)) for log in logs.values()]
    tables = [t for t in tables if len(t.s.rows) >= _LEAST_ROWS]
    if not tables or model.effects:
        return silent
    engine = _Joint(tables, sideways=model.base == "kinematic_bicycle")
    return {name: engine.opinion(name, named) for name in named}


class _Joint:
    """All forms on all tables, with each block's normal equations, so that effects are judged beside each other."""

    def __init__(self, tables: Sequence[_Table], *, sideways: bool) -> None:
        """sideways: the model steers as these equations do; one with slipping tyres does not. What its tyres and a late
        steering leave over in the yaw rate would then go to whatever else moves a bit of it, so it is not looked at."""
        self.tables = tables
        self.rests = [{n: rest for n, rest in t.rest.items() if sideways or n not in STEERED} for t in tables]
        self.forms = {
            f.name: f for f in FORMS
            if all(getattr(t.s, n) is not None for t in tables for n in f.needs)
            and (sideways or "steer" not in f.needs)
        }  # fmt: skip
        self._known: dict[tuple[str, float], FloatArray | None] = {}
        self._moves = {name: self._moved(form) for name, form in self.forms.items()}
        self.rest = np.concatenate([rest for rests in self.rests for rest in rests.values()] or [np.zeros(0)])
        self.count = len(self.rest)
        folds = [np.tile(t.fold, len(rests)) for t, rests in zip(tables, self.rests, strict=True)]
        self.fold = np.concatenate(folds)

    def columns(self, name: str, p: float) -> FloatArray | None:
        """The whole regressor (N, q) of a form in units of the noise; None if it moves nothing that was measured."""
        key = name, p
        if key not in self._known:
            self._known[key] = self._made(self.forms[name], p)
        return self._known[key]

    def _made(self, form: Form, p: float) -> FloatArray | None:
        made, width = [], 0
        for t in self.tables:
            own = form.of(t.s, p)
            width = max([width, *(v.shape[1] if v.ndim == 2 else 1 for v in own.values())])
            made.append(own)
        if not width:
            return None
        rows = []
        for t, rests, own in zip(self.tables, self.rests, made, strict=True):
            for name, rest in rests.items():
                values = own.get(name)
                if values is None:
                    rows.append(np.zeros((len(rest), width)))
                else:
                    rows.append((values if values.ndim == 2 else values[:, None]) / t.s.noise[name])
        found = np.concatenate(rows)
        return found if np.isfinite(found).all() and found.any() else None

    def opinion(self, name: str, named: Mapping[str, Mapping[str, float]]) -> Opinion:
        if name not in self.forms:
            return Opinion()
        rest, linear = self.rest, []
        for other, values in named.items():
            if other == name or other not in self.forms:
                continue
            form = self.forms[other]
            columns = self.columns(other, next(iter(values.values())) if form.grid and values else 0.0)
            if columns is not None and form.grid:
                rest = rest - columns[:, 0]
            elif columns is not None:
                linear.append(columns)
        beside = np.concatenate(linear, axis=1) if linear else np.zeros((len(rest), 0))
        left = self._left_out(rest, beside)
        found: dict[str, tuple[float, float]] = {}
        for other in self._rivals(name, named):
            tried = self._gain(other, rest, beside, left)
            if tried is not None:
                found[other] = tried
        if name not in found or not np.isfinite(left):
            return Opinion()
        mine = found[name][0]
        first = max(found, key=lambda other: found[other][0])
        gain, p = found[first]
        worth = _WORTH * max(float(self.count), left - gain)
        if gain < worth:
            return Opinion()
        if first == name or gain <= _CLEARLY * max(mine, 0.0) or gain - mine <= worth:
            return Opinion("agrees")
        if mine > worth and self._beside(name, first, p, rest, beside) > _KEPT * mine:
            return Opinion("agrees")  # the other one explains something else
        return Opinion("disagrees", first)

    def _rivals(self, name: str, named: Mapping[str, Mapping[str, float]]) -> list[str]:
        """The effect itself, and what may be meant in its place: effects that are not named, in no finer form either,
        and that move something that it moves. A body that sways explains nothing of a drive without power."""
        from vehicle.model.effect_catalogue import catalogue

        known = catalogue()  # a user's own effect is a finer form of nothing
        taken = {*named, *(known[each].diagnosed.details for each in named if each in known)} - {name}
        mine = self._moves[name]
        return [other for other, its in self._moves.items() if other not in taken and (other == name or mine & its)]

    def _moved(self, form: Form) -> set[str]:
        """Series that a form adds something to."""
        p = form.grid[0] if form.grid else 0.0
        return {
            series for t, rests in zip(self.tables, self.rests, strict=True)
            for series, values in form.of(t.s, p).items() if series in rests and np.any(values)
        }  # fmt: skip

    def _beside(self, name: str, other: str, p: float, rest: FloatArray, beside: FloatArray) -> float:
        """chi^2 that an effect takes off beside another one as well."""
        columns = self.columns(other, p)
        assert columns is not None
        if self.forms[other].grid:
            rest = rest - columns[:, 0]
        else:
            beside = np.concatenate([beside, columns], axis=1)
        gain = self._gain(name, rest, beside, self._left_out(rest, beside))
        return gain[0] if gain else 0.0

    def _gain(self, name: str, rest: FloatArray, beside: FloatArray, left: float) -> tuple[float, float] | None:
        """chi^2 that a form takes off blocks left out, beside linear columns, and where; None if it moves nothing."""
        form = self.forms[name]
        best: tuple[float, float] | None = None
        for p in form.grid or (0.0,):
            columns = self.columns(name, p)
            if columns is None:
                continue
            after = self._left_out(rest - columns[:, 0], beside) if form.grid else self._left_out(
                rest, np.concatenate([beside, columns], axis=1)
            )  # fmt: skip
            if np.isfinite(after) and (best is None or left - after > best[0]):
                best = left - after, p
        return best

    def _left_out(self, rest: FloatArray, columns: FloatArray) -> float:
        """chi^2 of each block with the unknowns of the columns (N, q) as the other blocks have them."""
        if not columns.shape[1]:
            return float(rest @ rest)
        a = np.stack([columns[self.fold == k].T @ columns[self.fold == k] for k in range(_FOLDS)])
        b = np.stack([columns[self.fold == k].T @ rest[self.fold == k] for k in range(_FOLDS)])
        return float(rest @ rest) - _linear(a, b)


class _Table:
    """The equations of a log in units of their noise."""

    def __init__(self, s: Signals) -> None:
        self.s = s
        expected = base(s)
        self.rest = {name: (s.measured[name] - expected[name]) / s.noise[name] for name in s.measured}
        self.fold = (s.t[s.rows] // _BLOCK).astype(np.int64) % _FOLDS
        self.count = sum(len(r) for r in self.rest.values())
        self.chi2 = float(sum(r @ r for r in self.rest.values()))

    def sums(self, columns: Columns) -> tuple[FloatArray, FloatArray] | None:
        """Normal equations a (k, q, q), b (k, q) by fold; None if none of the series was measured."""
        found: tuple[FloatArray, FloatArray] | None = None
        for name, values in columns.items():
            if name not in self.rest:
                continue
            phi = (values if values.ndim == 2 else values[:, None]) / self.s.noise[name]
            if found is None:
                q = phi.shape[1]
                found = np.zeros((_FOLDS, q, q)), np.zeros((_FOLDS, q))
            for k in range(_FOLDS):
                own = self.fold == k
                found[0][k] += phi[own].T @ phi[own]
                found[1][k] += phi[own].T @ self.rest[name][own]
        return found


def _gain(form: Form, tables: Sequence[_Table]) -> tuple[float, int] | None:
    """chi^2 that an effect takes away on blocks left out, and its number of unknowns."""
    usable = [t for t in tables if all(getattr(t.s, name) is not None for name in form.needs)]
    if not usable:
        return None
    if not form.grid:
        found = _summed(form, usable, 0.0)
        return None if found is None else (_linear(*found), found[1].shape[1])
    gains = {p: _fixed(form, usable, p) for p in form.grid}
    if any(g is None for g in gains.values()):
        return None
    known = {p: g for p, g in gains.items() if g is not None}
    best = max(known, key=lambda p: float(known[p].sum()))
    for ratio in (0.55, 0.75, 0.9, 1.1, 1.25, 1.6):
        step = form.grid[-1] / form.grid[-2]
        p = best * step ** (np.log(ratio) / np.log(2.0))
        g = _fixed(form, usable, float(p))
        if g is not None:
            known[float(p)] = g
    table = np.array(list(known.values()))
    total = 0.0
    for k in range(_FOLDS):
        chosen = int(np.argmax(table.sum(axis=1) - table[:, k]))
        total += float(table[chosen, k])
    return total, 1


def _summed(form: Form, tables: Sequence[_Table], p: float) -> tuple[FloatArray, FloatArray] | None:
    pairs = [pair for t in tables if (pair := t.sums(form.of(t.s, p))) is not None]
    if not pairs:
        return None
    return np.sum([a for a, _ in pairs], axis=0), np.sum([b for _, b in pairs], axis=0)


def _fixed(form: Form, tables: Sequence[_Table], p: float) -> FloatArray | None:
    """chi^2 taken away in each fold (k,)."""
    found = _summed(form, tables, p)
    return None if found is None else 2.0 * found[1][:, 0] - found[0][:, 0, 0]


def _linear(a: FloatArray, b: FloatArray) -> float:
    total, whole_a, whole_b = 0.0, a.sum(axis=0), b.sum(axis=0)
    for k in range(_FOLDS):
        scale = 1e-9 * float(np.trace(whole_a)) + 1e-300
        theta = np.linalg.solve(whole_a - a[k] + scale * np.eye(a.shape[1]), whole_b - b[k])
        total += float(2.0 * theta @ b[k] - theta @ a[k] @ theta)
    return total
