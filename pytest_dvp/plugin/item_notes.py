"""What a session and its tests remember: settings, the running test, its runs and variants."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import pytest

from pytest_dvp.drive.run_spec import RunSpec
from pytest_dvp.plugin.run_summary import RunSummary

if TYPE_CHECKING:
    from pytest_dvp.campaigns.variant import Variant


SETTINGS_KEY = pytest.StashKey[RunSpec]()


ITEM_KEY = pytest.StashKey[pytest.Item]()


VARIANT_KEY = pytest.StashKey["tuple[Variant | None, Mapping[str, Any]]"]()


RESULTS_KEY = pytest.StashKey[dict[tuple[str, str], RunSummary]]()


def settings_of(config: pytest.Config) -> RunSpec:
    """The session's settings, as the plugin read them."""
    return config.stash[SETTINGS_KEY]


def current_item(config: pytest.Config) -> pytest.Item:
    """The test that runs now."""
    return config.stash[ITEM_KEY]


def note(node: pytest.Item, result: Mapping[str, Any]) -> None:
    """Remember a run of this test; of those of one scenario and stage one stands for all (Hypothesis runs many)."""
    from pytest_dvp.text.searching import searching

    known, key = node.stash.setdefault(RESULTS_KEY, {}), (result["scenario"], result["stage"])
    if key in known:
        known[key].add_run(result)
    else:
        known[key] = RunSummary(dict(result))
    if searching():
        known[key].count(result)


def note_variant(node: pytest.Item, variant: Variant | None, options: Mapping[str, Any]) -> None:
    """Remember the variant this test drives now, and the options of its run.

    The last one of a failing test is the smallest Hypothesis found.
    """
    node.stash[VARIANT_KEY] = (variant, options)
