"""The page of the reference stack: every fault is on it, a missed figure cannot be overlooked, old sections stay."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from ads.planning.nets import NETS
from scripts.ads_report import PAGE, SECTIONS, TEXT, kept, section

FAULTS = Path(__file__).parents[2] / "faults" / "faults.toml"
MET = {"name": "a|b", "found": "1 m", "goal": "<= 2 m", "met": True}


def test_the_text_that_the_report_begins_with_is_that_of_the_page() -> None:
    text = TEXT.read_text(encoding="utf-8").format(nets=", ".join(net.name for net in NETS))
    assert PAGE.read_text(encoding="utf-8").partition("\n<!-- ")[0] == text


def test_every_fault_is_on_the_page_and_no_other() -> None:
    page = PAGE.read_text(encoding="utf-8").partition("### The faults")[2]
    rows = [line.split(" | ")[1] for line in page.splitlines() if line.startswith("| ")][1:]
    assert rows == [fault["name"] for fault in tomllib.loads(FAULTS.read_text())["fault"]]


def test_a_figure_that_is_missed_stands_out() -> None:
    rows = section("control", "Control", [MET, MET | {"met": False}]).splitlines()[-2:]
    assert [row.split(" | ")[-1] for row in rows] == ["yes |", "**no** |"]
    assert rows[0].startswith("| a\\|b | 1 m | <= 2 m |")


def test_a_section_that_is_not_measured_stays_as_it_was() -> None:
    one, two = section("localization", "L", [MET]), section("control", "C", [MET])
    page = "# Head\n" + one + two
    assert (kept(page, "localization"), kept(page, "control"), kept(page, "faults")) == (one, two, "")


def test_sections_stand_in_their_order() -> None:
    found = re.findall(r"<!-- (\w+) -->", PAGE.read_text(encoding="utf-8"))
    assert found == [key for key, _, _ in SECTIONS if key in found]


def found(figure: str) -> str:
    """What the page has for the figure whose name begins so."""
    (row,) = [line for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith(f"| {figure}")]
    return row.split(" | ")[1]


def test_readme_tells_both_figures_of_the_faults_as_the_page_has_them() -> None:
    """What gates see that are tightened to the stack, and what those see that ship."""
    total = len(tomllib.loads(FAULTS.read_text())["fault"])
    tightened = round(float(found("seeded faults that make a gate fail").removesuffix(" %")) / 100.0 * total)
    own = found("seeded faults that a gate that ships does not pass").partition(" ")[0]
    anywhere = found("the same in at least one of the 6 scenarios").partition(" ")[0]
    readme = " ".join((PAGE.parents[1] / "README.md").read_text(encoding="utf-8").split())
    assert f"{total} faults that were seeded into it. Under gates tightened to this stack, {tightened} of the" in readme
    assert (
        f"Under the gates that ship, {own} do not pass if each fault is driven in its scenario, and {anywhere} if"
        in readme
    )


def test_a_figure_without_a_goal_is_neither_met_nor_missed() -> None:
    assert section("shipped", "S", [MET | {"met": None}]).splitlines()[-1].endswith("|  |")
