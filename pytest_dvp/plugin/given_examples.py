"""A test with `@given` around the examples that Hypothesis makes: what decided nothing, and the smallest failure."""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import inspect
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, example, given, settings
from hypothesis import strategies as st

from pytest_dvp.campaigns.variant import Variant
from pytest_dvp.plugin.fixtures import Undecided
from pytest_dvp.plugin.item_notes import RESULTS_KEY, VARIANT_KEY

Test = Callable[..., object]
Place = tuple[type[BaseException], int]  # kind and line of a failure: by these Hypothesis tells two of them apart

SMALLEST, INCONCLUSIVE = "Smallest failing example", "Smallest inconclusive example"


def is_searched(item: pytest.Item) -> bool:
    """Whether an item is a test with `@given` that drives."""
    inner = getattr(getattr(getattr(item, "obj", None), "hypothesis", None), "inner_test", None)
    drives = "run" in getattr(item, "fixturenames", ())
    return drives and inner is not None and not inspect.iscoroutinefunction(inner)


@dataclasses.dataclass(frozen=True)
class Example:
    """A call of the test that did not pass: its arguments, the error, and what the session remembered of it then."""

    arguments: tuple[Any, ...]
    named: Mapping[str, Any]
    error: Exception
    state: tuple[object, Mapping[Any, Any]]

    @property
    def variants(self) -> dict[str, Variant]:
        """Those of the named arguments that are variants of a scenario."""
        return {name: value for name, value in self.named.items() if isinstance(value, Variant)}

    @property
    def changed(self) -> int:
        """Number of parameters that are not nominal."""
        return sum(len(variant.values) for variant in self.variants.values())


class Searched:
    """Runs the examples of one test.

    An example whose verdict is INCONCLUSIVE does not end the search, so that it hides no failure, and it is no pass:
    where nothing fails, the test ends with it. Of a failure the smallest variant is told that still fails.
    """

    def __init__(self, item: Any) -> None:
        self._item = item
        self._handle: Any = self._item.obj.hypothesis
        self._test: Any = self._handle.inner_test
        self._examples = 0
        self._undecided: list[Example] = []
        self._failed: dict[Place, Example] = {}

    @contextlib.contextmanager
    def watched(self) -> Iterator[None]:
        """Within it, Hypothesis calls the test through this object; at its end it raises what the test ends with."""
        __tracebackhide__ = True
        self._handle.inner_test = self._watched_test()
        try:
            yield
        except Exception as error:
            smaller = self._smaller(error)
            if smaller is error:
                raise
            raise smaller from None
        finally:
            self._handle.inner_test = self._test
        if self._undecided:
            raise self._inconclusive() from None

    def _watched_test(self) -> Test:
        @functools.wraps(self._test)
        def watched_test(*arguments: Any, **named: Any) -> object:
            __tracebackhide__ = True
            self._examples += 1
            try:
                return self._test(*arguments, **named)
            except Undecided as error:
                self._undecided.append(Example(arguments, named, error, self._state()))
                return None
            except Exception as error:
                self._failed[self._place(error)] = Example(arguments, named, error, self._state())
                raise

        return watched_test

    def _smaller(self, error: Exception) -> Exception:
        """The failure of the smallest variant; `error` itself where Hypothesis found it, or no variant is to blame."""
        if type(error) is ExceptionGroup:  # several failures at once
            parts = [self._smaller(part) for part in error.exceptions]
            same = all(one is other for one, other in zip(parts, error.exceptions, strict=True))
            return error if same else ExceptionGroup(error.message, parts)
        failed = self._failed.get(self._place(error))
        if failed is None:
            return error
        found = self._shrunk(failed)
        self._restore(found)
        if found is failed:
            return error
        self._note(SMALLEST, found)
        return found.error

    def _inconclusive(self) -> Exception:
        """What a test ends with in which no example failed, and some decided nothing."""
        found = self._shrunk(min(self._undecided, key=lambda one: one.changed))
        self._restore(found)
        assert isinstance(found.error, Undecided)
        head, _, rest = str(found.error).partition("\n")
        many = f"{len(self._undecided)} of {self._examples} examples INCONCLUSIVE, none failed"
        error = Undecided(f"{head} ({many})\n{rest}", found.error.result).with_traceback(found.error.__traceback__)
        self._note(INCONCLUSIVE, dataclasses.replace(found, error=error))
        return error

    def _shrunk(self, first: Example) -> Example:
        """The example with the smallest variants that ends in the same way."""
        if not first.changed or not self._may_shrink(first):
            return first
        from pytest_dvp.plugin.smallest_failure import smallest

        kept, place = [first], self._place(first.error)

        def fails(name: str, variant: Variant) -> bool:
            named = {**kept[-1].named, name: variant}
            error = self._once(first.arguments, named)
            if error is None or self._place(error) != place:
                return False
            kept.append(Example(first.arguments, named, error, self._state()))
            return True

        noted = self._item.stash.get(RESULTS_KEY, {}).values()
        counted = [(one, len(one.silent)) for one in noted]
        for name, variant in first.variants.items():
            smallest(variant, functools.partial(fails, name))
        for one, count in counted:
            del one.silent[count:]  # the variants of the search are counted, not what follows it
        return kept[-1]

    def _may_shrink(self, one: Example) -> bool:
        """Whether a user wants failures to be shrunk, and an example can be driven again from its arguments."""
        chosen = getattr(self._item.obj, "_hypothesis_internal_use_settings", None) or settings.default
        interactive = any(isinstance(value, st.DataObject) for value in one.named.values())
        return not interactive and (chosen is None or Phase.shrink in chosen.phases)

    def _once(self, arguments: tuple[Any, ...], named: Mapping[str, Any]) -> Exception | None:
        """The error of the test with these arguments; within Hypothesis, so that `assume` and `note` can be called."""

        @settings(phases=[Phase.explicit], deadline=None, database=None, suppress_health_check=list(HealthCheck))
        @example(None)
        @given(st.none())
        def once(_: None) -> None:
            self._test(*arguments, **named)

        try:
            once()
        except pytest.skip.Exception:
            return None
        except Exception as error:
            notes = getattr(error, "__notes__", [])
            notes[:] = [note for note in notes if ": once(" not in note]  # how Hypothesis calls this example
            return error
        return None

    def _place(self, error: BaseException) -> Place:
        file, line, frame = self._test.__code__.co_filename, 0, error.__traceback__
        while frame is not None:
            line = frame.tb_lineno if frame.tb_frame.f_code.co_filename == file else line
            frame = frame.tb_next
        return type(error), line

    def _state(self) -> tuple[object, Mapping[Any, Any]]:
        stash = self._item.stash
        return stash.get(VARIANT_KEY, None), {key: noted.last for key, noted in stash.get(RESULTS_KEY, {}).items()}

    def _restore(self, found: Example) -> None:
        """Let the session remember this example as the last one: its report tells of that."""
        variant, results = found.state
        if variant is not None:
            self._item.stash[VARIANT_KEY] = variant
        for key, result in results.items():
            self._item.stash[RESULTS_KEY][key].last = result

    def _note(self, what: str, found: Example) -> None:
        drawn = [f"    {name}={value!r}," for name, value in found.named.items() if name not in self._item.funcargs]
        found.error.add_note("\n".join([f"{what}: {self._item.originalname}(", *drawn, ")"]))
