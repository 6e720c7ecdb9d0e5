"""Several logs on one command line keep names that tell them apart."""

from __future__ import annotations

import pytest

from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.log_names import log_names


@pytest.mark.parametrize(
    ("arguments", "names"),
    [
        (["a/drive.csv", "b/slalom.csv"], ["drive.csv", "slalom.csv"]),
        (["a/drive.csv", "drive.csv"], ["a/drive.csv", "drive.csv"]),
        (["drive.csv", "a/drive.csv"], ["drive.csv", "a/drive.csv"]),
        (["a/drive.csv", "b/drive.csv", "c.csv"], ["a/drive.csv", "b/drive.csv", "c.csv"]),
    ],
)
def test_no_log_takes_the_place_of_another(arguments: list[str], names: list[str]) -> None:
    assert log_names(arguments) == names


def test_a_log_that_is_named_twice_is_refused() -> None:
    with pytest.raises(LogError, match=r"^drive\.csv: the log is named 2 times, expected each log once$"):
        log_names(["drive.csv", "./drive.csv"])
