"""Kept simulations: a file that somebody spoilt counts as none, and is simulated again."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_dvp.workers.cache import Cache


@pytest.mark.parametrize("data", [b"", b'{"metrics": ', b"[]", b'{"metrics": 5}', b"\xff\xfe{", b'{"a":' * 100_000])
def test_a_spoilt_file_is_none_and_is_written_anew(tmp_path: Path, data: bytes) -> None:
    cache = Cache(tmp_path)
    cache.put("ab12", {"metrics": {"tet": 0.0}})
    (file,) = tmp_path.glob("*/*.json")
    file.write_bytes(data)
    assert cache.get("ab12") is None
    cache.put("ab12", {"metrics": {"tet": 0.0}})
    assert cache.get("ab12") == {"metrics": {"tet": 0.0}}
