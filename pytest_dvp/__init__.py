"""The harness: runs scenarios, computes metrics, judges gates. Names load when they are first used."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pytest_dvp.assertions import assert_matches
    from pytest_dvp.fuzz import scenario_variants
    from pytest_dvp.log import Log
    from pytest_dvp.run import RunResult, run
    from pytest_dvp.variant import Variant

__all__ = ["Log", "RunResult", "Variant", "assert_matches", "run", "scenario_variants"]

# pytest imports this package in every session that has the plugin installed, so nothing heavy may load here.
_HOMES = {
    "Log": "pytest_dvp.log",
    "RunResult": "pytest_dvp.run",
    "Variant": "pytest_dvp.variant",
    "assert_matches": "pytest_dvp.assertions",
    "run": "pytest_dvp.run",
    "scenario_variants": "pytest_dvp.fuzz",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    import importlib

    try:
        return getattr(importlib.import_module(_HOMES[name]), name)
    except ImportError:
        from pytest_dvp.own_packages import hidden_package

        hidden = hidden_package()
        if hidden is None:
            raise
        raise ImportError(hidden) from None
