"""The harness: runs scenarios, computes metrics, judges gates. Names load when they are first used."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pytest_dvp.rooms import side_by_side
from pytest_dvp.text import old_paths

if TYPE_CHECKING:
    __version__: str
    from pytest_dvp.campaigns.variant import Variant
    from pytest_dvp.drive.result import RunResult
    from pytest_dvp.drive.run import run
    from pytest_dvp.gap.assert_matches import assert_matches
    from pytest_dvp.gap.compare.compare import compare
    from pytest_dvp.gap.diagnose.diagnose import diagnose
    from pytest_dvp.gap.extend.extend import extend
    from pytest_dvp.logs.log import Log
    from pytest_dvp.plugin.scenario_strategy import scenario_variants

__all__ = [
    "Log",
    "RunResult",
    "Variant",
    "assert_matches",
    "compare",
    "diagnose",
    "extend",
    "run",
    "scenario_variants",
]

old_paths.install()
side_by_side.install()

# pytest imports this package in every session that has the plugin installed, so nothing heavy may load here.
_HOMES = {
    "Log": "pytest_dvp.logs.log",
    "RunResult": "pytest_dvp.drive.result",
    "Variant": "pytest_dvp.campaigns.variant",
    "assert_matches": "pytest_dvp.gap.assert_matches",
    "compare": "pytest_dvp.gap.compare.compare",
    "diagnose": "pytest_dvp.gap.diagnose.diagnose",
    "extend": "pytest_dvp.gap.extend.extend",
    "run": "pytest_dvp.drive.run",
    "scenario_variants": "pytest_dvp.plugin.scenario_strategy",
}


def __getattr__(name: str) -> Any:
    if name == "__version__":  # stands in pyproject.toml alone
        from importlib.metadata import version

        return version("pytest-dvp")
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    import importlib

    try:
        return getattr(importlib.import_module(_HOMES[name]), name)
    except ImportError:
        from pytest_dvp.plugin.shadowed_packages import hidden_package

        hidden = hidden_package()
        if hidden is None:
            raise
        raise ImportError(hidden) from None
