"""Budget and account: sizes as people write them, and what a file may unpack to, take in memory and have in rows."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

import pytest

from pytest_dvp.logs.account import Account, open_account
from pytest_dvp.logs.budget import Budget, budget_in_force, environment_of, in_force, parse_size, shown_size
from pytest_dvp.logs.log_error import LogError

MB = 1 << 20


@pytest.mark.parametrize(
    ("text", "size"),
    [
        ("1", 1), ("250000", 250_000), ("7B", 7), ("2k", 2000), ("500MB", 500 * 10**6), ("500 mb", 500 * 10**6),
        ("2GiB", 2 * 2**30), ("1.5KiB", 1536), ("1T", 10**12), (" 3 MiB ", 3 * 2**20), ("9007199254740993", 2**53 + 1),
    ],
)  # fmt: skip
def test_sizes_are_read_as_people_write_them(text: str, size: int) -> None:
    assert parse_size(text) == size


@pytest.mark.parametrize("text", ["", "0", "-1", "0.4", "1.5", "GB", "2 XB", "1e9", "nan", "0.0001kB", "２MB", "2GB2"])
def test_what_is_no_size_is_refused(text: str) -> None:
    with pytest.raises(ValueError):  # noqa: PT011 - the caller says what was found and allowed
        parse_size(text)


@pytest.mark.parametrize(
    ("count", "shown"),
    [
        (0, "0 bytes"), (1, "1 byte"), (999, "999 bytes"), (1000, "1 kB"), (33_400, "33.4 kB"), (10**6 - 1, "1000 kB"),
        (2**30, "1.07 GB"), (3 * 10**12, "3 TB"), (5 * 10**15, "5000 TB"),
    ],
)  # fmt: skip
def test_sizes_are_shown_to_people(count: int, shown: str) -> None:
    assert shown_size(count) == shown


@pytest.mark.parametrize("value", [0, -5, 1.5])
@pytest.mark.parametrize("name", ["log_bytes", "log_rows", "file_bytes"])
def test_a_budget_of_nothing_is_refused(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=rf"{name} is {value}, expected a whole number >= 1"):
        Budget(**{name: value})  # type: ignore[arg-type]


def test_a_budget_reaches_child_processes_and_ends_with_its_command(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DVP_MAX_LOG_ROWS", "7")
    monkeypatch.delenv("DVP_MAX_LOG_BYTES", raising=False)
    given = Budget(log_bytes=2000, log_rows=50)
    assert environment_of(given) == {"DVP_MAX_LOG_BYTES": "2000", "DVP_MAX_LOG_ROWS": "50"}
    with contextlib.suppress(KeyError), in_force(given):
        assert budget_in_force() == given
        raise KeyError  # a command that fails
    assert budget_in_force() == Budget(log_rows=7)
    assert "DVP_MAX_LOG_BYTES" not in os.environ


def test_a_variable_that_is_no_size_is_named() -> None:
    told = "environment DVP_MAX_FILE_BYTES is 'much', expected a whole number >= 1, or one with a unit: 500MB, 2GiB"
    with pytest.raises(ValueError, match=told):
        budget_in_force({"DVP_MAX_FILE_BYTES": "much"})


@pytest.mark.parametrize(
    ("size", "most"),
    [(33_000, 32 * MB), (10 * MB, 2000 * MB), (10 << 30, 2000 << 30)],
    ids=["small: 32 MiB", "200 times its file", "large, too: it is read piece by piece"],
)
def test_a_file_unpacks_to_200_times_its_size_and_to_32_mib_in_any_case(size: int, most: int) -> None:
    account = Account("a.mcap", size, Budget())
    account.unpack(most - 1)
    account.unpack(1)
    assert account.left == 0
    with pytest.raises(LogError) as caught:
        account.unpack(1)
    assert caught.value.code == "log.too_large"
    assert ("200 times the file" in str(caught.value)) is (most > 32 * MB)


@pytest.mark.parametrize(("size", "most"), [(33_000, 32 * MB), (10 << 30, 4 << 30)])
def test_a_log_takes_4_gib_of_memory_at_most(size: int, most: int) -> None:
    account = Account("a.mcap", size, Budget())
    account.table(most // 8 // 32, 32)  # numbers of 8 bytes
    with pytest.raises(LogError, match=r"a\.mcap: the log takes .* of memory or more, allowed: .*--max-log-bytes"):
        account.hold(1)


def test_what_a_budget_states_holds_for_unpacking_and_for_memory() -> None:
    for charge in (Account.unpack, Account.hold):
        account = Account("a.mcap", 500, Budget(log_bytes=1000))
        charge(account, 1000)
        with pytest.raises(LogError, match=r"1001 bytes .*allowed: 1000 bytes \(--max-log-bytes allows more\)"):
            charge(account, 1)


@pytest.mark.parametrize(("budget", "most"), [(Budget(), 50_000_000), (Budget(log_rows=10), 10)])
def test_rows_are_counted(budget: Budget, most: int) -> None:
    account = Account("a.csv", 500, budget)
    account.rows(most)
    with pytest.raises(LogError, match=rf"has {most + 1} rows or more, allowed: {most} \(--max-log-rows"):
        account.rows(most + 1)


@pytest.mark.parametrize(
    ("name", "most"), [("a.csv", 512 * MB), ("a.CSV", 512 * MB), ("a.mat", 512 * MB), ("a.mcap", 64 << 30)]
)
def test_a_file_that_is_read_as_a_whole_is_smaller_than_one_that_is_not(tmp_path: Path, name: str, most: int) -> None:
    path = tmp_path / name
    with path.open("wb") as file:
        file.truncate(most)  # sparse
    assert open_account(path).size == most
    with path.open("wb") as file:
        file.truncate(most + 1)
    with pytest.raises(LogError, match=r"the log is a file of .*--max-file-bytes allows more"):
        open_account(path)
    assert open_account(path, Budget(file_bytes=most + 1)).size == most + 1


def test_a_folder_counts_all_of_its_files(tmp_path: Path) -> None:
    for name in ("a.db3", "b.db3"):
        (tmp_path / name).write_bytes(bytes(600))
    assert open_account(tmp_path, Budget(file_bytes=1200)).size == 1200
    with pytest.raises(LogError, match="a file of 1200 bytes, allowed: 1199 bytes"):
        open_account(tmp_path, Budget(file_bytes=1199))


def test_what_is_no_file_is_no_log(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.csv")
    with pytest.raises(LogError, match=r"pipe\.csv: not a regular file"):
        open_account(tmp_path / "pipe.csv")
    with pytest.raises(LogError, match=r"none\.csv: the log cannot be read: No such file"):
        open_account(tmp_path / "none.csv")
