"""Which driving stack is tested: found by name, made with as much as it takes, asked for no more than `tick`.

A name is an entry point of the group `pytest_dvp.ads`, `module:Class`, a file `my_stack.py:Class`, or
`ros2:stack.toml`, a stack in a process of its own.
"""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import importlib
import importlib.util
import inspect
import math
import sys
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from pytest_dvp.paths import shown
from pytest_dvp.settings import REFERENCE, SettingError, unknown

if TYPE_CHECKING:
    from vehicle.messages import Command, Detection, FloatArray, Observation

ENTRY_POINTS = "pytest_dvp.ads"
REMOTE = "ros2:"


class AdsError(SettingError):
    """A driving stack that cannot be found, loaded or made; one line."""


class AdsFault(Exception):
    """A driving stack that broke its contract while it drove; one line."""


@dataclasses.dataclass(frozen=True)
class Ads:
    """A driving stack that was chosen.

    name     for people and the log, without a path
    word     what `--ads` takes to choose it again; None if no command line can name it
    factory  class or function that makes it, or the stack itself
    """

    name: str
    word: str | None
    factory: Any


def find_ads(asked: object = None, folders: Sequence[Path] = ()) -> Ads:
    """The driving stack asked for: a name, None for the reference stack, or a class, function or object.

    `folders` are searched for modules, besides what Python searches. Raises AdsError with the nearest name.
    """
    if asked is None or asked == REFERENCE:
        from ads.stack import Stack

        return Ads(REFERENCE, REFERENCE, Stack)
    if isinstance(asked, str):
        return _named(asked, folders)
    if not callable(asked) and not callable(getattr(asked, "tick", None)):
        raise AdsError(f"ads: found {_what(asked)}, expected a name, a class, a function or an object with tick()")
    name = getattr(asked, "__qualname__", None) or type(asked).__qualname__
    return Ads(str(name), _word(asked), asked)


def check_name(text: str, origin: str, base: Path) -> str:
    """A name as a setting gives it, files made absolute; loads nothing. Raises SettingError with the nearest name."""
    file, colon, name = text.rpartition(":")
    if text.startswith(REMOTE):
        path = (base / text.removeprefix(REMOTE)).absolute()
        if not path.is_file():
            raise SettingError(f"{origin}: no file {path}")
        return f"{REMOTE}{path}"
    if text.endswith(".py"):
        raise SettingError(f"{origin}: {text} is a file; name the class in it, as in {text}:Stack")
    if colon and file.endswith(".py"):
        path = (base / file).absolute()
        if not path.is_file():
            raise SettingError(f"{origin}: no file {path}")
        return f"{path}:{name}"
    if not colon:
        names = [REFERENCE, *_points()]
        if text not in names:
            raise SettingError(f"{origin}: {unknown('ADS', text, names)}; or name module:Class or file.py:Class")
    return text


def make_driver(ads: Ads, parameters: object, network: object, description: object) -> Any:
    """The stack itself, made with (parameters, network, description) if it takes them, else with nothing.

    Returns an object as `pytest_dvp.loop.Driver` describes it, whatever of trace, path and detections the stack has.
    Raises AdsError if it cannot be made so.
    """
    factory, given = ads.factory, (parameters, network, description)
    if callable(factory):
        takes = _takes(factory)
        if takes is None:
            raise AdsError(f"ADS {ads.name}: takes neither (parameters, network, description) nor nothing")
        if not takes and isinstance(getattr(factory, "parameters", None), Mapping):
            raise AdsError(f"ADS {ads.name}: declares parameters, and takes no (parameters, network, description)")
        try:
            made = factory(*given) if takes else factory()
        except (Exception, SystemExit) as error:  # a stack of somebody else may raise anything
            raise AdsError(f"ADS {ads.name}: cannot be made: {one_line(error)}") from error
    else:
        made = factory
    if not callable(getattr(made, "tick", None)):
        raise AdsError(f"ADS {ads.name}: {_made(made)} has no method tick(observation)")
    return OnlyTick(made, ads.name)


class OnlyTick:
    """A driver of which only `tick` is required; what it returns is checked."""

    def __init__(self, driver: Any, name: str) -> None:
        from vehicle.messages import Command, Detection

        self._driver, self._name, self._command, self._detection = driver, name, Command, Detection
        self._tick: Callable[[Observation], Command] = driver.tick
        self._given: object = None
        self._path: FloatArray | None = None

    def tick(self, observation: Observation) -> Command:
        """Raises AdsFault if the stack returns anything but a Command of finite numbers."""
        try:
            command = self._tick(observation)
        except SystemExit as error:  # it would end the harness, with an exit code that looks like a verdict
            raise AdsFault(f"ADS {self._name}: tick ended the program: {one_line(error)}") from None
        if not isinstance(command, self._command):
            raise AdsFault(f"ADS {self._name}: tick returned {_what(command)}, expected a vehicle.messages.Command")
        try:
            finite = math.isfinite(command.steer + command.accel + command.throttle + command.brake)
        except TypeError:
            raise AdsFault(
                f"ADS {self._name}: tick returned a Command of other things than numbers: {command}"
            ) from None
        if not finite:
            raise AdsFault(f"ADS {self._name}: tick returned a Command that is not finite: {command}")
        return command

    @property
    def trace(self) -> Mapping[str, float]:
        trace = getattr(self._driver, "trace", None) or {}
        if not isinstance(trace, Mapping):
            raise AdsFault(f"ADS {self._name}: trace is {_what(trace)}, expected names with numbers")
        for name, value in trace.items():
            if type(name) is not str or (type(value) is not float and not _is_number(value)):
                raise AdsFault(f"ADS {self._name}: trace has {name!r}: {_what(value)}, expected names with numbers")
        return trace

    @property
    def detections(self) -> Sequence[Detection]:
        found = getattr(self._driver, "detections", None)
        if found is None:
            return ()
        if not isinstance(found, Sequence) or not all(isinstance(each, self._detection) for each in found):
            what = "vehicle.messages.Detection in a list"
            raise AdsFault(f"ADS {self._name}: detections is {_what(found)}, expected {what}")
        return found

    @property
    def nets(self) -> list[Any]:
        """Nets that the stack decides by, as plain data, for the report; empty if it tells none."""
        nets = getattr(self._driver, "nets", None)
        return list(nets) if isinstance(nets, list | tuple) else []

    def close(self) -> None:
        """Free what the stack holds, if it has something to free: its method close()."""
        close = getattr(self._driver, "close", None)
        if callable(close):
            try:
                close()
            except (Exception, SystemExit) as error:  # what it drove is driven, and is kept
                print(f"ADS {self._name}: close: {one_line(error)}", file=sys.stderr)

    @property
    def path(self) -> FloatArray | None:
        """The stack's path as an array (n, 2), the same one until the stack gives another."""
        path = getattr(self._driver, "path", None)
        if path is not self._given:
            import numpy as np

            self._given = path
            try:
                self._path = None if path is None else np.asarray(path, dtype=np.float64)
            except (TypeError, ValueError):
                raise AdsFault(f"ADS {self._name}: path is {_what(path)}, expected an array (n, 2): x, y [m]") from None
            if self._path is not None and (self._path.ndim != 2 or self._path.shape[1] != 2):
                shape = self._path.shape
                raise AdsFault(f"ADS {self._name}: path has the shape {shape}, expected (n, 2): x, y [m]")
        return self._path


def one_line(error: BaseException) -> str:
    """Kind, text and innermost place of an error of somebody else's code."""
    frames = [f for f in traceback.extract_tb(error.__traceback__) if not f.filename.startswith("<")]
    frames = frames if frames and Path(frames[-1].filename).name != Path(__file__).name else []
    place = f" ({Path(frames[-1].filename).name}:{frames[-1].lineno})" if frames else ""
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text}{place}" if text else f"{type(error).__name__}{place}"


def _points() -> dict[str, EntryPoint]:
    return {point.name: point for point in sorted(entry_points(group=ENTRY_POINTS), key=lambda p: (p.name, p.value))}


def _named(text: str, folders: Sequence[Path]) -> Ads:
    checked = check_name(text, "ads", Path.cwd())
    if checked.startswith(REMOTE):
        from pytest_dvp.remote_stack import RemoteStack

        path = Path(checked.removeprefix(REMOTE))
        return Ads(f"{REMOTE}{path.name}", f"{REMOTE}{shown(path)}", RemoteStack(path, keep=False))
    file, colon, name = checked.rpartition(":")
    if not colon:
        point = _points()[text]
        with _importable(folders):
            try:
                return Ads(text, text, point.load())
            except (Exception, SystemExit) as error:  # a foreign package may raise anything while it loads
                where = f"entry point {text!r} ({point.value})"
                raise AdsError(f"ads: {where} cannot be loaded: {one_line(error)}") from error
    with _importable(folders):
        try:
            if file.endswith(".py"):
                path = Path(file)
                module = _module_of(path, path.stat().st_mtime_ns)
                label, word = f"{path.name}:{name}", f"{shown(path)}:{name}"
            else:
                module, label, word = importlib.import_module(file), text, text
        except (Exception, SystemExit) as error:
            raise AdsError(f"ads: {text} cannot be loaded: {one_line(error)}") from error
    found: Any = module
    for part in name.split("."):
        if not hasattr(found, part):
            names = [n for n, value in vars(found).items() if callable(value) and not n.startswith("_")]
            raise AdsError(f"ads: {text}: {unknown('class', part, names)}")
        found = getattr(found, part)
    if not callable(found):
        raise AdsError(f"ads: {text} is {_what(found)}, expected a class or a function that makes a stack")
    return Ads(label, word, found)


@functools.lru_cache(maxsize=16)
def _module_of(path: Path, changed: int) -> ModuleType:
    """A module from a file, loaded anew when the file has changed; its own folder is searched for what it imports."""
    name = f"dvp_ads_{path.stem}_{hashlib.sha256(f'{path}{changed}'.encode()).hexdigest()[:8]}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ImportError(f"{path} is no Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look their module up
    try:
        with _importable([path.parent]):
            spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    return module


@contextmanager
def _importable(folders: Sequence[Path]) -> Iterator[None]:
    """Modules in the folders can be imported meanwhile: a command of its own does not search the current folder."""
    more = [str(folder) for folder in dict.fromkeys([*folders, Path.cwd()]) if str(folder) not in sys.path]
    sys.path.extend(more)
    try:
        yield
    finally:
        for folder in more:
            sys.path.remove(folder)


def _takes(factory: Callable[..., Any]) -> bool | None:
    """True if it wants the three things, False if it wants nothing, None if neither would do."""
    try:
        signature = inspect.signature(factory)
    except ValueError:  # compiled code may not tell
        return True
    kinds = inspect.Parameter
    first = [p for p in signature.parameters.values() if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]
    meant = any(p.kind is kinds.VAR_POSITIONAL for p in signature.parameters.values()) or any(
        p.default is kinds.empty or p.name in ("parameters", "network", "description") for p in first
    )
    if meant and _binds(signature, 3):
        return True
    return False if _binds(signature, 0) else None


def _binds(signature: inspect.Signature, count: int) -> bool:
    try:
        signature.bind(*range(count))
    except TypeError:
        return False
    return True


def _word(asked: Any) -> str | None:
    """What a command line calls a class or function; None for one that is made inside a function or is an object."""
    name, home = getattr(asked, "__qualname__", ""), sys.modules.get(getattr(asked, "__module__", None) or "")
    found: Any = home
    for part in name.split(".") if name else ():
        found = getattr(found, part, None)
    if not name or home is None or found is not asked:
        return None
    file = getattr(home, "__file__", None)
    if getattr(home, "__package__", ""):
        return f"{home.__name__}:{name}"
    return f"{shown(Path(file))}:{name}" if file else None


def _made(thing: object) -> str:
    return f"a {type(thing).__name__}" if " at 0x" in repr(thing) else _what(thing)


def _is_number(value: Any) -> bool:
    try:
        float(value)
    except (TypeError, ValueError):
        return False
    return not isinstance(value, str | bytes)


def _what(thing: object) -> str:
    if thing is None:
        return "None"
    kind = type(thing)
    text = " ".join(repr(thing).split())
    said = text if len(text) <= 60 else text[:57] + "..."
    return f"{said} ({kind.__name__})"
