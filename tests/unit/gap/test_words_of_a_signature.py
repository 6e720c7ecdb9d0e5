"""What an error that nothing explains looks like, in words."""

from __future__ import annotations

from typing import Any

import pytest

from pytest_dvp.gap.words.residual_signature import signature_lines

AXIS: dict[str, Any] = {"axis": "lateral", "regressors": [{"term": "t1", "held_out_share": 0.2},
                                                         {"term": "t2", "held_out_share": 0.456}]}  # fmt: skip


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({}, "follows t1, then t2 (46 % of it on segments left out)"),
        ({"regressors": []}, "follows nothing that was tried"),
        ({"regressors": None}, "follows nothing that was tried"),
        ({"speed": {"bin": "speed 0-5 m/s", "share_of_error": 0.5, "share_of_time": 0.25}},
         "follows t1, then t2 (46 % of it on segments left out); 50 % of it at 0-5 m/s, 25 % of the time"),
        ({"regressors": [], "speed": {"bin": "speed 0-5 m/s", "share_of_error": 0.5, "share_of_time": 0.41}},
         "follows nothing that was tried"),
        ({"regressors": [], "rhythm": [{"share": 0.3, "frequency": 1.2345, "unit": "Hz"}, None,
                                       {"share": 0.29, "frequency": 9.0, "unit": "1/m"}]},
         "follows nothing that was tried; 30 % of it repeats at 1.23 Hz"),
        ({"regressors": [], "trend": {"share_in_second_half": 0.8}},
         "follows nothing that was tried; 80 % of it in the second half"),
        ({"regressors": [], "trend": {"share_in_second_half": 0.79}}, "follows nothing that was tried"),
    ],
)  # fmt: skip
def test_what_an_error_looks_like_in_words(more: dict[str, Any], words: str) -> None:
    assert signature_lines({"reading": "r", "look_at": "l", "axes": [AXIS | more]}) == [
        ("looks like", "r"), ("look at", "l"), ("lateral", words),
    ]  # fmt: skip
    assert signature_lines({}) == signature_lines({"reading": "", "axes": []}) == []
