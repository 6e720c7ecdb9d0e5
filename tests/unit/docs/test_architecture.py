"""ARCHITECTURE.md, the decisions and the other pages name files that exist, and ARCHITECTURE.md stays short."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
ARCHITECTURE = ROOT / "ARCHITECTURE.md"
DECISIONS = ROOT / "docs" / "decisions"
MOST_LINES = 120  # two printed pages
ROOMS = ("machine_code", "openscenario", "vehicle", "ads", "reports", "pytest_dvp", "scenarios", "scripts")
PAGES = sorted([ARCHITECTURE, ROOT / "README.md", *(ROOT / "docs").rglob("*.md")])


def named_paths(text: str) -> list[str]:
    """Paths of this repository in backticks: files with an ending, and folders with a slash at the end.

    `tests/` is left out: the pages for users mean a folder of their own repository by it.
    """
    pattern = rf"`((?:{'|'.join(ROOMS)})/(?:[\w./-]*\.[a-z]+|[\w/-]*/)?)`"
    return re.findall(pattern, text)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_path_on_a_page_exists(page: Path) -> None:
    paths = named_paths(page.read_text(encoding="utf-8"))
    assert [path for path in paths if not (ROOT / path).exists()] == []


def test_architecture_names_the_files_of_a_change() -> None:
    assert len(set(named_paths(ARCHITECTURE.read_text(encoding="utf-8")))) >= 40


def test_architecture_stays_short() -> None:
    assert len(ARCHITECTURE.read_text(encoding="utf-8").splitlines()) <= MOST_LINES


def test_architecture_names_every_room_of_the_harness() -> None:
    text = ARCHITECTURE.read_text(encoding="utf-8")
    rooms = [path.parent.name for path in (ROOT / "pytest_dvp").glob("*/__init__.py")]
    assert [room for room in rooms if f"| `{room}/` |" not in text] == []


def test_links_of_architecture_lead_to_files() -> None:
    links = re.findall(r"\]\(([^)#:]+)\)", ARCHITECTURE.read_text(encoding="utf-8"))
    assert len(links) >= 3
    assert [link for link in links if not (ROOT / link).exists()] == []


def test_the_index_lists_every_decision() -> None:
    index = (DECISIONS / "README.md").read_text(encoding="utf-8")
    pages = [page.name for page in DECISIONS.glob("*.md") if page.name != "README.md"]
    assert len(pages) >= 20
    assert [page for page in pages if f"({page})" not in index] == []


@pytest.mark.parametrize("page", sorted(set(DECISIONS.glob("*.md")) - {DECISIONS / "README.md"}), ids=lambda p: p.stem)
def test_a_decision_says_what_why_what_else_and_since_when(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for part in ("# ", "**Decision.** ", "**Why.** ", "**Tried or rejected.** ", "**Since** 20", "**Where:** `"):
        assert part in text, part
    assert [link for link in re.findall(r"\]\(([^)#:]+)\)", text) if not (page.parent / link).exists()] == []
