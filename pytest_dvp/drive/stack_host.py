"""Which driving stack is tested: found by name, made with as much as it takes, asked for no more than `tick`.

A name is an entry point of the group `pytest_dvp.ads`, `module:Class`, a file `my_stack.py:Class`, or
`ros2:stack.toml`, a stack in a process of its own.
"""

from __future__ import annotations

import functools
import hashlib
import importlib
import importlib.util
import inspect
import math
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from pytest_dvp.drive.chosen_stack import Ads
from pytest_dvp.drive.stack_faults import AdsError, StackHung, one_line, place_of, what
from pytest_dvp.drive.stack_name import REMOTE, check_name, stack_entry_points
from pytest_dvp.text.names import REFERENCE
from pytest_dvp.text.paths import shown
from pytest_dvp.text.spelling import unknown

if TYPE_CHECKING:
    from pytest_dvp.drive.checked_stack import OnlyTick
    from pytest_dvp.drive.deadline import Deadline
    from pytest_dvp.drive.stack_process import ProcessDriver

ON, OFF = "on", "off"  # of a process of its own


def find_ads(
    asked: object = None, folders: Sequence[Path] = (), *, process: str | None = None, tick_limit: float | None = None
) -> Ads:
    """The driving stack asked for: a name, None for the reference stack, or a class, function or object.

    folders     are searched for modules, besides what Python searches
    process     "on": a stack given by name runs in a process of its own, "off": in this one; None: "on" for all but
                the reference stack. One that is given as a class or object always runs in this process.
    tick_limit  [s] of wall time that a tick of it has, and a multiple of it what is loaded; default 10

    Raises AdsError with the nearest name.
    """
    if isinstance(asked, Ads):
        return asked
    if asked is None or asked == REFERENCE:
        if process == ON:
            return _apart(REFERENCE, REFERENCE, folders, tick_limit)
        from ads.stack import Stack

        return Ads(REFERENCE, REFERENCE, Stack)
    if isinstance(asked, str):
        checked = check_name(asked, "ads", Path.cwd())
        if process != OFF and not checked.startswith(REMOTE):
            return _apart(asked, checked, folders, tick_limit)
        return _in_time(asked, checked, folders, tick_limit)
    if not callable(asked) and not callable(getattr(asked, "tick", None)):
        raise AdsError(f"ads: found {what(asked)}, expected a name, a class, a function or an object with tick()")
    word = _word(asked)
    if word is not None:  # called as by that word, or the log of its replay would be another one
        return Ads(_called(word)[0], word, asked)
    return Ads(str(getattr(asked, "__qualname__", None) or type(asked).__qualname__), None, asked)


def make_driver(
    ads: Ads, parameters: Any, network: Any, description: Any, deadline: Deadline | None = None
) -> OnlyTick | ProcessDriver:
    """The stack itself, made with (parameters, network, description) if it takes them, else with nothing.

    Returns an object as `pytest_dvp.drive.driver.Driver` describes it, with whatever of trace, path and detections the
    stack has.
    `deadline` is on every call of it; default none. Raises AdsError if it cannot be made so.
    """
    from pytest_dvp.drive.checked_stack import OnlyTick
    from pytest_dvp.drive.deadline import Deadline
    from pytest_dvp.drive.stack_process import NamedStack

    watch = deadline if deadline is not None else Deadline(ads.name, math.inf)
    if isinstance(ads.factory, NamedStack):
        return ads.factory.drive(parameters, network, description, watch)
    try:
        with watch.within("__init__", first=True):
            made = made_by(ads, (parameters, network, description))
        return OnlyTick(made, ads.name, watch)
    except BaseException as error:
        watch.close()
        if isinstance(error, StackHung):
            late = str(error).removeprefix(f"ADS {ads.name}: ")
            raise AdsError(f"ADS {ads.name}: cannot be made: {late}{place_of(error.trace)}") from None
        if isinstance(error, AdsError) or not isinstance(error, Exception | SystemExit):
            raise
        raise AdsError(f"ADS {ads.name}: cannot be made: {one_line(error)}") from error


def wants(ads: Ads) -> bool:
    """Whether the stack is made with (parameters, network, description), and not with nothing."""
    return callable(ads.factory) and bool(_takes(ads.factory))


def made_by(ads: Ads, given: tuple[Any, Any, Any]) -> Any:
    """The stack object of `ads`, made with `given` (parameters, network, description) if it takes them, else with
    nothing. Raises AdsError if it cannot be made so or has no tick; whatever the stack itself raises passes."""
    factory = ads.factory
    if callable(factory):
        takes = _takes(factory)
        if takes is None:
            raise AdsError(f"ADS {ads.name}: takes neither (parameters, network, description) nor nothing")
        if not takes and isinstance(getattr(factory, "parameters", None), Mapping):
            raise AdsError(f"ADS {ads.name}: declares parameters, and takes no (parameters, network, description)")
        made = factory(*given) if takes else factory()  # a stack of somebody else may raise anything
    else:
        made = factory
    if not callable(getattr(made, "tick", None)):
        raise AdsError(f"ADS {ads.name}: {_made(made)} has no method tick(observation)")
    return made


def _apart(text: str, checked: str, folders: Sequence[Path], tick_limit: float | None) -> Ads:
    """A stack given by name, loaded in a process of its own."""
    from pytest_dvp.drive.deadline import TICK_LIMIT
    from pytest_dvp.drive.stack_process import NamedStack

    label, word = _called(checked)
    return Ads(label, word, NamedStack(label, text, folders, TICK_LIMIT if tick_limit is None else tick_limit))


def _in_time(text: str, checked: str, folders: Sequence[Path], tick_limit: float | None) -> Ads:
    """A stack given by name, loaded in this process; one that never finishes loading is interrupted."""
    from pytest_dvp.drive.deadline import TICK_LIMIT, Deadline

    label = _called(checked)[0]
    watch = Deadline(label, TICK_LIMIT if tick_limit is None else tick_limit)
    try:
        with watch.within("import", first=True):
            return _named(text, checked, folders)
    except StackHung as error:
        late = str(error).removeprefix(f"ADS {label}: ")
        raise AdsError(f"ads: {text} cannot be loaded: {late}{place_of(error.trace)}") from None
    finally:
        watch.close()


def _called(checked: str) -> tuple[str, str]:
    """What people and the log call a stack of a checked name, and what `--ads` takes to choose it again."""
    file, _, name = checked.rpartition(":")
    if not file.endswith(".py"):
        return checked, checked
    return f"{Path(file).name}:{name}", f"{shown(Path(file))}:{name}"


def _named(text: str, checked: str, folders: Sequence[Path]) -> Ads:
    """A stack given by name, loaded in this process."""
    if checked.startswith(REMOTE):
        from pytest_dvp.drive.remote_stack import RemoteStack

        path = Path(checked.removeprefix(REMOTE))
        return Ads(f"{REMOTE}{path.name}", f"{REMOTE}{shown(path)}", RemoteStack(path, keep=False))
    file, colon, name = checked.rpartition(":")
    label, word = _called(checked)
    if not colon:
        point = stack_entry_points()[text]
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
            else:
                module = importlib.import_module(file)
        except (Exception, SystemExit) as error:
            raise AdsError(f"ads: {text} cannot be loaded: {one_line(error)}") from error
    found: Any = module
    for part in name.split("."):
        if not hasattr(found, part):
            names = [n for n, value in vars(found).items() if callable(value) and not n.startswith("_")]
            raise AdsError(f"ads: {text}: {unknown('class', part, names)}")
        found = getattr(found, part)
    if not callable(found):
        raise AdsError(f"ads: {text} is {what(found)}, expected a class or a function that makes a stack")
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
    return f"a {type(thing).__name__}" if " at 0x" in repr(thing) else what(thing)
