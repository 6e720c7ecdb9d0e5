"""Interpreted binary Petri nets, as data: places, transitions, guards over named facts, a parent place.

A place holds one token or none. A transition may fire when its input places hold tokens, its output places that are not
inputs hold none, every fact in `when` is true and none in `unless` is. A net with a parent runs only while the parent
place is marked and keeps its marking in between: that makes the nets hierarchical.
Source: David, Alla, Discrete, Continuous and Hybrid Petri Nets (2010), ch. 1 and 3.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping


@dataclasses.dataclass(frozen=True)
class Transition:
    """Moves tokens from the places `take` to the places `give`, guarded by facts."""

    name: str
    take: tuple[str, ...]
    give: tuple[str, ...]
    when: tuple[str, ...] = ()
    unless: tuple[str, ...] = ()


@dataclasses.dataclass(frozen=True)
class Net:
    """A net. `actions` says in words what a marked place does; `parent` is "net.place" or empty.

    Raises: ValueError for a transition that names an unknown place, or a place without an action.
    """

    name: str
    initial: tuple[str, ...]
    actions: Mapping[str, str]
    transitions: tuple[Transition, ...]
    parent: str = ""

    def __post_init__(self) -> None:
        for transition in self.transitions:
            for place in (*transition.take, *transition.give):
                if place not in self.actions:
                    raise ValueError(f"net {self.name}, transition {transition.name}: unknown place {place!r}")
        for place in self.initial:
            if place not in self.actions:
                raise ValueError(f"net {self.name}: unknown initial place {place!r}")

    @property
    def places(self) -> tuple[str, ...]:
        """Names of the places, in order."""
        return tuple(self.actions)

    @property
    def facts(self) -> frozenset[str]:
        """Names of all facts that guards refer to."""
        return frozenset(f for t in self.transitions for f in (*t.when, *t.unless))

    def enabled(self, marking: frozenset[str]) -> tuple[Transition, ...]:
        """Transitions that the marking lets fire, guards aside."""
        return tuple(t for t in self.transitions if _may_fire(t, marking))

    def fire(self, marking: frozenset[str], transition: Transition) -> frozenset[str]:
        """The marking after an enabled transition.

        Raises: ValueError if it is not enabled.
        """
        if not _may_fire(transition, marking):
            raise ValueError(f"net {self.name}: transition {transition.name} is not enabled")
        return (marking - frozenset(transition.take)) | frozenset(transition.give)

    def reachable(self) -> frozenset[frozenset[str]]:
        """All markings that some sequence of transitions can reach, whatever the facts."""
        start = frozenset(self.initial)
        seen, todo = {start}, [start]
        while todo:
            marking = todo.pop()
            for transition in self.enabled(marking):
                after = self.fire(marking, transition)
                if after not in seen:
                    seen.add(after)
                    todo.append(after)
        return frozenset(seen)


def _may_fire(transition: Transition, marking: frozenset[str]) -> bool:
    take = frozenset(transition.take)
    return take <= marking and not (frozenset(transition.give) - take) & marking


class NetSystem:
    """Nets at work. Parents must come before their children."""

    def __init__(self, nets: tuple[Net, ...]) -> None:
        self.nets = nets
        self._marking = [frozenset(net.initial) for net in nets]
        self._index = {net.name: i for i, net in enumerate(nets)}
        self._by_place = [{p: tuple(t for t in net.transitions if p in t.take) for p in net.actions} for net in nets]
        self.trace: dict[str, float] = {}
        self._quiet: Mapping[str, bool] | None = None  # facts of the last step, if it fired nothing
        for i in range(len(nets)):
            self._note(i)

    def marked(self, net: str, place: str) -> bool:
        """Whether a place holds a token."""
        return place in self._marking[self._index[net]]

    def step(self, facts: Mapping[str, bool]) -> tuple[str, ...]:
        """Fire what the facts let fire, each transition at most once; returns "net.transition" in firing order."""
        if facts == self._quiet:  # neither facts nor marking have changed
            return ()
        fired: list[str] = []
        for i, net in enumerate(self.nets):
            if net.parent:
                name, _, place = net.parent.partition(".")
                if not self.marked(name, place):
                    continue
            done: set[str] = set()
            again = True
            while again:
                again = False
                marking = self._marking[i]
                for place in net.actions:
                    if place not in marking:
                        continue
                    for transition in self._by_place[i][place]:
                        if transition.name in done or not _holds(transition, facts):
                            continue
                        if not _may_fire(transition, marking):
                            continue
                        self._marking[i] = net.fire(marking, transition)
                        done.add(transition.name)
                        fired.append(f"{net.name}.{transition.name}")
                        again = True
                        break
                    if again:
                        break
            if done:
                self._note(i)
        self._quiet = None if fired else dict(facts)
        return tuple(fired)

    def _note(self, i: int) -> None:
        net = self.nets[i]
        for place in net.actions:
            self.trace[f"net.{net.name}.{place}"] = 1.0 if place in self._marking[i] else 0.0


def _holds(transition: Transition, facts: Mapping[str, bool]) -> bool:
    for fact in transition.when:
        if not facts[fact]:
            return False
    return all(not facts[fact] for fact in transition.unless)
