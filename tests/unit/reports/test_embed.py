"""Data in a page: the same numbers come back, whatever they are."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from contents import filled

from reports.embed import ARRAYS, LONG, compact, embed

NOISE = np.random.default_rng(3).normal(size=500)
COURSES: dict[str, list[Any]] = {
    "a time": np.round(np.arange(0.0, 5.0, 0.01), 3).tolist(),
    "rounded noise": np.round(NOISE, 4).tolist(),
    "with gaps": [None, *np.round(NOISE, 3).tolist(), None],
    "only gaps": [None] * LONG,
    "finer than six decimals": NOISE.tolist(),
    "large": [1e17 * k for k in range(LONG)],
    "whole numbers": list(range(LONG)),
    "nested": [[1.0, 2.5], [None, 3.0]] * LONG,
}


@pytest.mark.parametrize("name", COURSES)
def test_a_long_list_comes_back_number_for_number(name: str) -> None:
    data = {"curve": {"y": COURSES[name]}, "label": "v"}
    written = json.loads(embed(compact(data)))
    assert ARRAYS in written
    assert filled(written) == data


def test_short_lists_and_texts_stay_readable() -> None:
    data = {"short": [1.0] * (LONG - 1), "texts": ["a"] * LONG, "flags": [True] * LONG, "objects": [{"t": [0.5]}]}
    assert compact(data) == data


def test_compact_data_are_compact() -> None:
    assert compact(compact({"y": COURSES["a time"]})) == compact({"y": COURSES["a time"]})


def test_numbers_that_are_none_are_refused() -> None:
    with pytest.raises(ValueError, match="JSON"):
        compact({"y": [float("inf")] * LONG})
