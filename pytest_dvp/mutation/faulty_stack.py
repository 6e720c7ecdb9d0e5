"""A stack behind a fault: any stack, made as it is made without one."""

from __future__ import annotations

from typing import Any

from pytest_dvp.drive.chosen_stack import Ads
from pytest_dvp.drive.stack_host import made_by
from pytest_dvp.mutation.fault import Fault, Memory
from vehicle.messages import Command, Observation


class FaultyStack:
    """The stack `inner`, whose observations, commands or map a fault changes; all else that it offers is its own."""

    def __init__(self, inner: Any, fault: Fault) -> None:
        self._inner, self._fault, self._memory = inner, fault, Memory()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._inner, name)

    def tick(self, observation: Observation) -> Command:
        """The command that reaches the car."""
        memory, fault = self._memory, self._fault
        memory.observations.append(observation)
        if fault.sees is not None:
            observation = fault.sees(observation, memory)
        command = self._inner.tick(observation)
        memory.commands.append(command)
        if fault.sends is not None:
            command = fault.sends(command, memory)
        memory.tick += 1
        return command  # type: ignore[no-any-return]


def behind(ads: Ads, fault: Fault) -> Any:
    """A factory that makes the stack behind the fault, with the parameters and the sensors that the stack declares."""

    def make(parameters: Any, network: Any, description: Any) -> FaultyStack:
        given = network if fault.maps is None else fault.maps(network)
        return FaultyStack(made_by(ads, (parameters, given, description)), fault)

    for name in ("parameters", "reads"):
        own = getattr(ads.factory, name, None)
        if own is not None:
            setattr(make, name, own)
    return make
