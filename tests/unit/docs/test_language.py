"""User-facing texts use none of the phrases that docs/glossary.md retires: pages, README, help texts of `dvp`."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from pytest_dvp.cli.dispatch import build_parser

ROOT = Path(__file__).parents[3]
GLOSSARY = ROOT / "docs" / "glossary.md"
TOP = ("README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md")
PAGES = sorted({path for name in TOP if (path := ROOT / name).exists()} | {*(ROOT / "docs").rglob("*.md")} - {GLOSSARY})
BEING_REWRITTEN: frozenset[str] = frozenset()


def rows() -> list[tuple[str, str, str]]:
    """Term, meaning and last column of each line of the glossary."""
    return re.findall(r"^\| \*\*(.+?)\*\* \| (.+) \| (.+) \|$", GLOSSARY.read_text(encoding="utf-8"), re.MULTILINE)


def retired() -> list[str]:
    """Phrases in quotation marks in the last columns of the glossary's tables, in lower case."""
    lines = [line for line in GLOSSARY.read_text(encoding="utf-8").splitlines() if line.startswith("| ")]
    return [phrase.lower() for line in lines for phrase in re.findall(r'"([^"]+)"', line.rsplit(" | ", 1)[1])]


def prose(text: str) -> str:
    """A page without code blocks, code and targets of links, in lower case and on one line."""
    text = re.sub(r"^```.*?^```", " ", text, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"^ {4}\S.*$", " ", text, flags=re.MULTILINE)
    text = re.sub(r"`[^`]*`|\]\([^)]*\)", " ", text)
    return " ".join(text.split()).lower()


def found_in(text: str) -> list[str]:
    return [phrase for phrase in retired() if re.search(rf"\b{re.escape(phrase)}\b", text)]


def helps(parser: argparse.ArgumentParser) -> Iterator[tuple[str, str]]:
    """Name and text of each description and help text of a parser and its commands."""
    yield parser.prog, parser.description or ""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                yield from helps(command)
        elif action.help and action.help != argparse.SUPPRESS and action.dest not in BEING_REWRITTEN:
            yield f"{parser.prog} {action.dest}", action.help


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_a_page_uses_no_retired_phrase(page: Path) -> None:
    assert found_in(prose(page.read_text(encoding="utf-8"))) == []


def test_help_texts_use_no_retired_phrase() -> None:
    texts = dict(helps(build_parser()))
    assert len(texts) > 150
    assert {name: found for name, text in texts.items() if (found := found_in(prose(text)))} == {}


def test_a_retired_phrase_is_found() -> None:
    assert found_in(prose("It passes the *command\ngate*.".replace("*", ""))) == ["command gate"]
    assert found_in(prose("Columns `command gate`, and\n\n```\nthe command gate\n```\n")) == []


def test_a_single_common_word_is_not_banned() -> None:
    assert len(retired()) >= 20
    assert [phrase for phrase in retired() if " " not in phrase] == []


def test_the_glossary_has_one_whole_line_for_each_term() -> None:
    terms = [term.lower() for term, _, _ in rows()]
    assert len(terms) >= 40
    assert terms == sorted(set(terms))
    assert [term for term, meaning, _ in rows() if len(meaning.split()) < 5] == []


def test_the_glossary_is_linked_where_a_reader_begins() -> None:
    assert "docs/glossary.md" in (ROOT / "README.md").read_text(encoding="utf-8")
    assert "(glossary.md)" in (ROOT / "docs" / "README.md").read_text(encoding="utf-8")
