"""Parameters P of a driving stack: those that it declares itself, else those of the reference stack.

A stack declares them by an attribute `parameters` of its class (or of the function that makes it), names with their
defaults, `{"LK_look": 1.2}`; it is then given a dict of all of them. A stack without gets `ads.parameters.Parameters`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

from pytest_dvp.drive.chosen_stack import Ads
from pytest_dvp.drive.stack_faults import AdsError
from pytest_dvp.text.errors import SettingError
from pytest_dvp.text.names import REFERENCE
from pytest_dvp.text.spelling import unknown

if TYPE_CHECKING:
    from ads.parameters import Parameters

Own: TypeAlias = dict[str, int | float]
"""Names and values of a stack that declares its own."""


def declared(ads: Ads) -> Own | None:
    """The parameters that a stack declares, with their defaults; None if it declares none.

    Raises AdsError for one that is no finite number.
    """
    found = getattr(ads.factory, "parameters", None) if callable(ads.factory) else None
    if not isinstance(found, Mapping) or not found:  # a property, a method, an object of its own: means another thing
        return None
    for name, value in found.items():
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise AdsError(f"ADS {ads.name}: parameters: the default of {name} is {value!r}, expected a finite number")
    return dict(found)


def in_force(ads: Ads, values: Mapping[str, Any], stage: str) -> Parameters | Own:
    """What the stack is made with: its own parameters, or those of the reference stack, with `values` set.

    Raises AdsError (own) or ParameterError (reference) for an unknown name, with the nearest one, or a wrong value.
    """
    own = declared(ads)
    if own is not None:
        return {**own, **{name: _checked(ads, own, name, value) for name, value in values.items()}}
    from ads.parameters import preset

    return preset(10, stage).with_values(values)


def as_plain(parameters: Any) -> dict[str, float]:
    """Name to value, of either kind of parameters."""
    return dict(parameters) if isinstance(parameters, Mapping) else parameters.as_dict()


def check_parameters(ads: Ads, values: Mapping[str, Any], option: str = "--set") -> None:
    """Raises SettingError, one line, unless `values` are allowed values of the stack's P."""
    if not values:
        return
    from ads.parameters import ParameterError

    try:
        in_force(ads, values, "dt")
    except ParameterError as error:
        raise SettingError(f"{option}: {error}{_whose(ads)}") from None
    except AdsError as error:
        raise AdsError(f"{option}: {error}") from None


def known_of(ads: Ads, values: Mapping[str, Any]) -> dict[str, Any]:
    """Of `values` those that the stack has."""
    from ads.parameters import Parameters

    own = declared(ads)
    names = Parameters().as_dict() if own is None else own
    return {name: value for name, value in values.items() if name in names}


def received(ads: Ads, sent: Mapping[str, Any]) -> Parameters | Own:
    """What a stack of this process is made with, of the P that came over the wire.

    If the harness knows of none of its own, those of the reference stack come, which are not for it.
    Raises as `in_force`.
    """
    from ads.parameters import Parameters

    own = declared(ads)
    others = () if own is None else [name for name in Parameters().as_dict() if name not in own]
    return in_force(ads, {name: value for name, value in sent.items() if name not in others}, "dt")


def _whose(ads: Ads) -> str:
    if ads.word == REFERENCE:
        return ""
    return f" (ADS {ads.name} declares no `parameters` of its own, so P is that of the reference stack)"


def _checked(ads: Ads, own: Own, name: str, value: Any) -> int | float:
    """A value as the kind of number that its default is."""
    if name not in own:
        raise AdsError(f"ADS {ads.name}: {unknown('parameter', name, own)}")
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if isinstance(value, bool) or not math.isfinite(number):
        raise AdsError(f"ADS {ads.name}: parameter {name}: found {value!r}, expected a finite number")
    if isinstance(own[name], float):
        return number
    if not number.is_integer():
        said = f"expected a whole number, as its default {own[name]} is ({own[name]}.0 allows any)"
        raise AdsError(f"ADS {ads.name}: parameter {name}: found {value}, {said}")
    return int(number)
