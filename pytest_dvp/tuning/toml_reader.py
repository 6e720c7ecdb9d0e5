"""Reads the TOML of studies and plans, with errors that name file, line, what was found and what is allowed."""

from __future__ import annotations

import contextlib
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from pytest_dvp.text.errors import SettingError
from pytest_dvp.text.spelling import nearest, unknown
from pytest_dvp.tuning.objective import ALIGNMENT, PERFORMANCE, Constraint, Kind, Objective, Term
from pytest_dvp.tuning.plausible_ranges import of_s, unit_of
from pytest_dvp.tuning.study import Variant
from pytest_dvp.tuning.tuned_parameter import Knob, rounded, typed
from pytest_dvp.workers.errors import TuneError
from vehicle.toml_file import TomlError, read_toml

if TYPE_CHECKING:
    from pytest_dvp.drive.chosen_stack import Ads
    from pytest_dvp.drive.stack_parameters import Own

_OTHERS = {
    "iterate": "a plan (dvp iterate)",
    "study": "a study (dvp tune)",
    "model": "a vehicle model",
    "gate": "a gate file",
    "signal": "a mapping file",
}
_KNOB = ("values", "start", "plausible")
OF_A_DRIVE = ("missed_events",)
_SIGNALS = ("x", "y", "yaw", "v", "yaw_rate", "ax", "ay", "steer")


class Reader:
    """The TOML of a study or a plan. Every complaint is a TuneError with file and line."""

    def __init__(self, path: Path) -> None:
        try:
            self.data, self.text = read_toml(path)
        except TomlError as error:
            text = f"cannot be read: {error}" if error.kind == "unreadable" else str(error)
            raise TuneError(text, file=str(path), line=error.line) from None
        self.path = path
        self.ads: Ads | None = None  # None: the reference stack

    def own_P(self) -> Own | None:
        """What the stack declares with its defaults, None for the parameters of the reference stack."""
        from pytest_dvp.drive.stack_parameters import declared

        return None if self.ads is None else declared(self.ads)

    def fail(self, word: str, message: str) -> NoReturn:
        """Raise TuneError with the first line of the file that holds `word`, or line 1."""
        line = next((n for n, t in enumerate(self.text.splitlines(), 1) if re.search(rf"{re.escape(word)}", t)), 1)
        raise TuneError(message, file=str(self.path), line=line)

    def stack(self, name: str) -> Ads:
        """The driving stack of a study, a file of one's own: its folder says when a kept simulation is stale."""
        from pytest_dvp.drive.stack_host import find_ads
        from pytest_dvp.drive.stack_name import check_name
        from pytest_dvp.drive.stack_parameters import declared

        beside = self.path.parent.absolute()
        if not name.partition(":")[0].endswith(".py"):
            self.fail("ads", f"ads is {name!r}, expected FILE.py:Class")
        try:
            there = (beside / name.rpartition(":")[0]).is_file()
            found = find_ads(check_name(name, "ads", beside if there else Path.cwd()), [beside])
            declared(found)
        except SettingError as error:
            self.fail("ads", str(error))
        return found

    def presets(self, kind: Kind, preset: int, stage: str, stated: bool) -> tuple[dict[str, float], dict[str, float]]:
        """P of a preset (it always has one; of a stack of one's own its defaults), S if the file states the preset."""
        from ads.parameters import preset as preset_p
        from vehicle.model.simulator_parameters import preset_s

        own = self.own_P()
        given = preset_p(preset, stage).as_dict() if own is None else own
        P = {} if kind == "alignment" else {f"P.{n}": float(v) for n, v in given.items()}
        if not stated or (kind == "performance" and stage != "dt"):
            return P, {}
        S: dict[str, float] = preset_s(preset, stage)  # type: ignore[arg-type]
        S.pop("PEDESTRIAN_speed")  # the scenario's: [[scenario]] set
        return P, {f"S.{name}": value for name, value in S.items()}

    def knobs(self, presets: Mapping[str, float]) -> tuple[tuple[Knob, ...], dict[str, float]]:
        """The knobs of [parameters] and their starts: the stated start, else that of `presets`. Raises TuneError."""
        knobs, start = [], {}
        for name, raw in self.table(self.data.get("parameters", {}), "parameters").items():
            if name in ("P", "S") and isinstance(raw, dict) and not set(raw) & set(_KNOB):
                inside = next(iter(raw), "NAME")
                self.fail(f"{name}.{inside}", f'{name}.{inside} needs quotes: "{name}.{inside}" = [...]')
            if not isinstance(raw, list | dict):
                self.fail(name, f"{name} is {raw!r}, expected [values] or {{ values = [...], start = ... }}")
            entry = {"values": raw} if isinstance(raw, list) else self.table(raw, name)
            self.known(entry, _KNOB, f"key of {name}")
            unit = self.unit(name)
            values = self.numbers(entry, "values", name)
            first = self.number(entry["start"], name) if "start" in entry else presets.get(name)
            if first is None:
                self.fail(name, f"{name}: states no start, and no preset has it")
            if len({*values, first}) < 2:
                self.fail(name, f"{name}: values = {values}: fewer than two candidates, nothing to choose from")
            stated = self.numbers(entry, "plausible", name)
            if stated and (len(stated) != 2 or stated[0] >= stated[1]):
                self.fail(name, f"{name}: plausible = {stated}, expected [low, high]")
            plausible = (stated[0], stated[1]) if stated else of_s(name)
            candidates = tuple(sorted({rounded(v) for v in (*values, first)}))
            knobs.append(Knob(name, unit, candidates, plausible, self.whole_numbers(name)))
            start[name] = rounded(first)
            for value in candidates:
                self.allowed({name: value})
        if not knobs:
            self.fail("study", 'no parameter to tune: [parameters] "P.NAME" = [...] or "S.NAME" = [...]')
        return tuple(knobs), start

    def whole_numbers(self, name: str) -> bool:
        """Whether a parameter takes whole numbers only: those of a stack of one's own whose default is one."""
        own = self.own_P() or {}
        return name.startswith("P.") and isinstance(own.get(name[2:]), int)

    def unit(self, name: str) -> str:
        """The unit of a parameter P.NAME or S.NAME. Raises TuneError if there is no such parameter."""
        if name.startswith("P.") and self.own_P() is not None:
            self.allowed({name: 0.0})
            return ""
        try:
            return unit_of(name)
        except ValueError as error:
            self.fail(name, str(error))

    def allowed(self, values: Mapping[str, float]) -> None:
        """Raises TuneError if a parameter P.NAME or S.NAME cannot have its value."""
        from ads.parameters import ParameterError, Parameters
        from pytest_dvp.drive.stack_faults import AdsError
        from pytest_dvp.drive.stack_parameters import in_force
        from vehicle.model.errors import ModelError
        from vehicle.model.simulator_parameters import check_s

        for name, value in values.items():
            group, _, rest = name.partition(".")
            try:
                if group == "P" and self.ads is not None:
                    in_force(self.ads, {rest: value}, "dt")
                elif group == "P":
                    Parameters().with_values({rest: value})
                else:
                    check_s({rest: value})
            except (ParameterError, ModelError, AdsError) as error:
                self.fail(name, str(error))

    def objective(self, kind: Kind) -> Objective:
        """Terms and constraints of the file; where it states none, those of the usual objective. Raises TuneError."""
        default = PERFORMANCE if kind == "performance" else ALIGNMENT
        terms = [self.term(entry, kind) for entry in self.tables("term")]
        constraints = [self.constraint(entry, kind) for entry in self.tables("constraint")]
        try:
            return Objective(kind, tuple(terms) or default.terms, tuple(constraints) or default.constraints)
        except TuneError as error:
            self.fail("term", str(error))

    def constraint(self, entry: Mapping[str, Any], kind: Kind) -> Constraint:
        """One [[constraint]]: metric, max and min; without both, max is 0. Raises TuneError."""
        self.known(entry, ("metric", "max", "min"), "key of [[constraint]]")
        name = self.metric(entry, kind)
        if "max" not in entry and "min" not in entry and not best_at_0(name, kind):
            wanted = "expected max = ... or min = ..."
            self.fail(name, f"{name}: without a max or min it must be 0, where it is not best; {wanted}")
        bounds = {key: self.number(entry[key], key) for key in ("max", "min") if key in entry} or {"max": 0.0}
        high, low = bounds.get("max", math.inf), bounds.get("min", -math.inf)
        if low > high:
            self.fail(name, f"{name}: min = {low:g} is more than max = {high:g}, so no value is allowed")
        return Constraint(name, high, low)

    def term(self, entry: Mapping[str, Any], kind: Kind) -> Term:
        """One [[term]]: metric, scale (> 0), weight and target. Raises TuneError."""
        self.known(entry, ("metric", "scale", "weight", "target"), "key of [[term]]")
        numbers = {key: self.number(entry[key], key) for key in ("scale", "weight", "target") if key in entry}
        if numbers.get("scale", 1.0) <= 0.0:
            self.fail(
                "scale", f"scale = {numbers['scale']:g}, expected more than 0: what one unit of the metric is worth"
            )
        scale, weight, target = (
            numbers.get(key, default) for key, default in (("scale", 1.0), ("weight", 1.0), ("target", 0.0))
        )
        name = self.metric(entry, kind)
        if "target" not in entry and not best_at_0(name, kind):
            self.fail(name, f"{name}: without a target it is brought to 0, where it is not best; expected target = ...")
        return Term(name, scale, weight, target, above=name == "log10.chi2_per_n")  # as in the terms that ship

    def metric(self, entry: Mapping[str, Any], kind: Kind) -> str:
        """The metric that an entry names. Raises TuneError if the kind of study has no such metric."""
        name = str(entry.get("metric", ""))
        known = metric_names(kind)
        if name not in known:
            self.fail(name or "metric", unknown(f"metric of {kind}", name, known))
        return name

    def variants(self, table: str = "scenario") -> tuple[Variant, ...]:
        """The scenarios of [[scenario]], or of another table, with their parameters. Raises TuneError."""
        from pytest_dvp.drive.parameter_checks import check_declared

        found = []
        for entry in self.tables(table):
            self.known(entry, ("file", "set"), f"key of [[{table}]]")
            file = self.file(str(entry.get("file", "")), "scenario")
            if file.suffix.lower() != ".xosc":
                self.fail(file.name, f"scenario {file.name!r}, expected an .xosc file")
            values = {name: self.number(value, name) for name, value in self.table(entry.get("set", {}), "set").items()}
            for name, value in values.items():
                try:
                    check_declared(file, {name: typed(value)}, "set")
                except SettingError as error:
                    self.fail(name, str(error))
            found.append(Variant(file, values))
        return tuple(found)

    def file(self, name: Any, what: str) -> Path:
        """The file beside the study, else from here, else among what ships. Raises TuneError if it is in none."""
        from scenarios import path as shipped

        if not isinstance(name, str) or "\0" in name:
            self.fail(what, f"{what} is {name!r}, expected the name of a {what} in quotes")
        beside = self.path.parent / name
        try:
            if name and beside.exists():
                return beside
            if name and Path(name).exists():
                return Path(name)
            return shipped(name)
        except OSError as error:
            if not isinstance(error, FileNotFoundError):
                self.fail(name[:40], f"{what} {name!r}: {error.strerror}")
            self.absent(name, what)
        except ValueError:
            self.absent(name, what)

    def absent(self, name: str, what: str) -> NoReturn:
        """Raise TuneError for a file that is nowhere, with the nearest existing name."""
        from scenarios import path as shipped

        meant = _meant(name, (self.path.parent, shipped("overtaking.xosc").parent))
        self.fail(name or what, f"no {what} {name!r}: neither beside the study nor here nor among what ships{meant}")

    def vehicle(self, text: str) -> str:
        """The vehicle as a run takes it, its file of hidden effects with its path. Raises TuneError for a real car."""
        from pytest_dvp.drive.run_spec import SIMULATED
        from pytest_dvp.drive.stages import StageError

        try:
            refuse_real_car(text)
        except StageError as error:
            self.fail("vehicle", str(error))
        name, colon, hidden = text.partition(":")
        if name not in SIMULATED:
            return text
        return f"{name}:{self.file(hidden, 'file of hidden effects')}" if colon else text

    def known(self, given: Iterable[str], names: Sequence[str], what: str) -> None:
        """Raises TuneError at the first name that is none of `names`; `what` says in words what it was to be."""
        for name in given:
            if name not in names:
                self.fail(name, unknown(what, name, names))

    def tables_of(self, names: Sequence[str], what: str) -> None:
        """Refuses a file of another kind, and a table that this kind does not have."""
        for name, kind in _OTHERS.items():
            if name in self.data and name not in names:
                self.fail(f"[{name}", f"this is {kind}, not {what}")
        self.known(self.data, names, "table")

    def table(self, raw: Any, name: str) -> dict[str, Any]:
        """The value as a table. Raises TuneError if it is none."""
        if not isinstance(raw, dict):
            self.fail(name, f"{name} is {raw!r}, expected a table")
        return raw

    def tables(self, name: str) -> list[dict[str, Any]]:
        """The tables [[name]] of the file, [] if it has none. Raises TuneError if the key holds something else."""
        raw = self.data.get(name, [])
        if not isinstance(raw, list):
            self.fail(name, f"{name} is a table, expected [[{name}]]")
        return [self.table(entry, name) for entry in raw]

    def number(self, raw: Any, name: str) -> float:
        """The value as a finite number. Raises TuneError if it is none."""
        if isinstance(raw, bool) or not isinstance(raw, int | float) or raw != raw or abs(raw) == float("inf"):
            self.fail(name, f"{name}: {raw!r}, expected a number")
        return float(raw)

    def numbers(self, entry: Mapping[str, Any], key: str, name: str) -> list[float]:
        """The finite numbers under a key, [] without it. Raises TuneError if it holds something else."""
        raw = entry.get(key, [])
        if not isinstance(raw, list):
            self.fail(name, f"{name}: {key} is {raw!r}, expected a list of numbers")
        return [self.number(value, name) for value in raw]

    def whole(
        self, table: Mapping[str, Any], key: str, default: int, allowed: Sequence[int] = (), *, least: int = 0
    ) -> int:
        """The whole number under a key, >= `least` and one of `allowed` if that is not empty. Raises TuneError."""
        raw = table.get(key, default)
        if isinstance(raw, bool) or not isinstance(raw, int) or raw < least or (allowed and raw not in allowed):
            wanted = ", ".join(map(str, allowed)) or f"a whole number >= {least}"
            self.fail(key, f"{key} is {raw!r}, expected {wanted}")
        return raw

    def wholes(self, table: Mapping[str, Any], key: str, default: Sequence[int]) -> list[int]:
        """The whole numbers >= 0 under a key, one at least. Raises TuneError."""
        raw = table.get(key, list(default))
        if not isinstance(raw, list) or not raw:
            self.fail(key, f"{key} is {raw!r}, expected a list of whole numbers, one at least")
        return [self.whole({key: value}, key, 0) for value in raw]

    def words(self, table: Mapping[str, Any], key: str) -> list[str]:
        """The names under a key, [] without it. Raises TuneError if it holds something else."""
        raw = table.get(key, [])
        if not isinstance(raw, list) or not all(isinstance(word, str) for word in raw):
            self.fail(key, f"{key} is {raw!r}, expected a list of names")
        return raw

    def word(self, table: Mapping[str, Any], key: str, allowed: Sequence[Any], default: Any) -> Any:
        """The value under a key, one of `allowed`. Raises TuneError if it is none of them."""
        raw = table.get(key, default)
        if raw not in allowed:
            self.fail(key, unknown(key, str(raw), allowed))
        return raw


def refuse_real_car(vehicle: str) -> None:
    """Raises StageError for a vehicle that nothing automatic may drive, and for one that nobody knows."""
    from pytest_dvp.drive.announced_cars import find_adapter, refuse_repetition
    from pytest_dvp.drive.stages import REPLAY, VEHICLES

    name = vehicle.partition(":")[0]
    if name not in (*VEHICLES, REPLAY):
        find_adapter(name)
        refuse_repetition("tuning", "rw", vehicle)


def _meant(name: str, folders: Iterable[Path]) -> str:
    """`; did you mean 'overtaking.xosc'?`: the nearest name of that kind in these folders, empty if none is near."""
    wanted = Path(name)
    there: list[str] = []
    for folder in (folder / wanted.parent for folder in folders if wanted.name):
        with contextlib.suppress(OSError):  # no such folder, or one that may not be read
            there += [str(wanted.with_name(file.name)) for file in folder.iterdir() if file.suffix == wanted.suffix]
    near = nearest(name, there)
    return "" if near is None else f"; did you mean {near!r}?"


def best_at_0(name: str, kind: Kind) -> bool:
    """Whether 0 is what a metric should be: not a distance to others, of which more is better, nor a gain, which should
    be 1."""
    if kind == "alignment":
        return not name.startswith(("mncc.", "gain."))
    from pytest_dvp.metrics import find_metric

    if name in OF_A_DRIVE:
        return True
    metric = find_metric(name)
    return metric.bigger_is_worse is not False and not metric.ideal


def metric_names(kind: Kind) -> list[str]:
    """Names that a term or constraint of this kind may use."""
    if kind == "alignment":
        kinds = ("rmse", "nrmse", "chi2_per_n", "mncc", "lag", "gain")
        return ["chi2_per_n", "log10.chi2_per_n", *(f"{k}.{s}" for k in kinds for s in _SIGNALS)]
    from pytest_dvp.metrics import known_metrics
    from pytest_dvp.metrics.metric import REQUIRED

    single = [n for n, m in known_metrics().items() if m.logs == 1 and REQUIRED not in m.options.values()]
    return [*single, *OF_A_DRIVE]
