"""Paths: what leaves the allowed folders is refused before the disk is asked."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from openscenario.paths import PathError, Roots


@pytest.fixture
def roots(tmp_path: Path) -> Roots:
    (tmp_path / "scenario").mkdir()
    (tmp_path / "library").mkdir()
    (tmp_path / "scenario" / "road.xodr").write_text("road")
    (tmp_path / "library" / "far.xodr").write_text("far")
    (tmp_path / "secret.txt").write_text("secret")
    return Roots.of(tmp_path / "scenario", [tmp_path / "library"])


def code(roots: Roots, written: str) -> str:
    with pytest.raises(PathError) as caught:
        roots.find(written, roots.base)
    return caught.value.code


def test_own_folder_and_library_are_open(roots: Roots) -> None:
    assert roots.find("road.xodr", roots.base).read_text() == "road"
    assert roots.find("../library/far.xodr", roots.base).read_text() == "far"
    assert roots.find("..\\library\\far.xodr", roots.base).read_text() == "far"


@pytest.mark.parametrize(
    "written",
    [
        "/etc/passwd",
        "../secret.txt",
        "../../../../../../etc/passwd",
        "..%2fsecret.txt",
        "..%252fsecret.txt",
        "%2e%2e/secret.txt",
        "\\\\127.0.0.1\\share\\road.xodr",
        "//127.0.0.1/share/road.xodr",
        "C:\\road.xodr",
        "c:/road.xodr",
        "x/../../secret.txt",
        "../scenario_other/road.xodr",
        "../librarian/road.xodr",
    ],
)
def test_what_leaves_the_folders_is_refused(roots: Roots, written: str) -> None:
    assert code(roots, written) == "path.outside_root"


@pytest.mark.parametrize("written", ["http://127.0.0.1:9/a", "file:///etc/passwd", "FTP://x/y", "data:text/xml,x"])
def test_schemes_are_refused(roots: Roots, written: str) -> None:
    assert code(roots, written) == "path.scheme_forbidden"


def test_a_link_that_leads_out_is_refused(roots: Roots, tmp_path: Path) -> None:
    (tmp_path / "scenario" / "link.xodr").symlink_to(tmp_path / "secret.txt")
    assert code(roots, "link.xodr") == "path.outside_root"


def test_a_link_that_leads_to_a_library_is_followed(roots: Roots, tmp_path: Path) -> None:
    (tmp_path / "scenario" / "link.xodr").symlink_to(tmp_path / "library" / "far.xodr")
    assert roots.find("link.xodr", roots.base).read_text() == "far"


def test_a_missing_file_shows_the_resolved_path_and_the_nearest_name(roots: Roots) -> None:
    with pytest.raises(PathError) as caught:
        roots.find("raod.xodr", roots.base)
    assert caught.value.code == "path.not_found"
    assert str(roots.real[0] / "raod.xodr") in caught.value.text
    assert "road.xodr" in caught.value.hint


def test_a_folder_and_a_pipe_are_no_regular_files(roots: Roots, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "scenario" / "pipe")
    assert code(roots, "pipe") == "path.not_a_file"
    assert code(roots, ".") == "path.not_a_file"
