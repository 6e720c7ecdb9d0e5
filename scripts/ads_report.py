"""Writes docs/ads.md: what the reference stack is made of, and every figure that it is held to, measured anew.

`make ads-report`, or `python -m scripts.ads_report [--clean-seeds N] [--variants N] [--only SECTION...]`; with --only,
the figures of the other sections stay as the page has them.
"""

from __future__ import annotations

import argparse
import importlib
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from ads.planning.nets import NETS

TEXT = Path(__file__).with_name("ads_page.md")
PAGE = Path(__file__).parents[1] / "docs" / "ads.md"
MET = {True: "met", False: "MISSED", None: "shown"}
Figure = dict[str, Any]

SECTIONS: tuple[tuple[str, str, str], ...] = (
    ("localization", "Localization", "scripts.ads_figures_localization"),
    ("perception", "Mapping and perception", "scripts.ads_figures_perception"),
    ("behaviour", "Planning and behaviour", "scripts.ads_figures_behaviour"),
    ("control", "Control, and the stack as a whole", "scripts.ads_figures_control"),
    ("parameters", "What P and S move in the scenarios that ship", "scripts.ads_figures_parameters"),
    ("shipped", "Faults seeded into it, under the gates that ship", "scripts.ads_figures_shipped"),
    ("faults", "Faults seeded into it, under gates tightened to it", "scripts.ads_figures_faults"),
)

FAULTS = """
### The faults

`tests/faults/faults.toml` holds them as data: what is changed, where, and which gate of which scenario should see it.
The bounds are those of the reference stack (`tests/faults/gates/`), tighter than the ones that ship. `make test` drives
a sample, `make nightly` all of them and 1,000 seeds without a fault; urban is driven without background traffic there.

| part | fault | scenario | gate | seen |
|---|---|---|---|---|
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--clean-seeds", type=int, default=1000, help="drives without a fault")
    parser.add_argument("--variants", type=int, default=500, help="variants of each scenario")
    parser.add_argument(
        "--only", nargs="+", choices=[key for key, _, _ in SECTIONS], help="measure these sections only"
    )
    asked = parser.parse_args()
    page = PAGE.read_text(encoding="utf-8") if PAGE.is_file() else ""
    head = TEXT.read_text(encoding="utf-8").format(nets=", ".join(net.name for net in NETS))
    parts = {key: kept(page, key) for key, _, _ in SECTIONS}
    for key, title, module in SECTIONS:
        if asked.only and key not in asked.only:
            continue
        try:
            source = importlib.import_module(module)
        except ModuleNotFoundError as error:
            if error.name != module:
                raise
            continue
        figures: Callable[..., Sequence[Figure]] = source.figures
        found = figures(*{"faults": [asked.clean_seeds], "behaviour": [asked.variants]}.get(key, []))
        below: Callable[[], str] = fault_table if key == "faults" else getattr(source, "text", str)
        parts[key] = section(key, title, found) + below()
        PAGE.write_text((head + "".join(parts.values())).rstrip() + "\n", encoding="utf-8")
        for figure in found:
            print(f"{MET[figure['met']]:6} {figure['name']}: {figure['found']} ({figure['goal']})")


def section(key: str, title: str, figures: Sequence[Figure]) -> str:
    """A table of figures; what is missed stands out. met: None for what has no goal."""
    said = {True: "yes", False: "**no**", None: ""}
    rows = [f"| {cell(f['name'])} | {cell(f['found'])} | {cell(f['goal'])} | {said[f['met']]} |" for f in figures]
    return "\n".join(
        [f"\n<!-- {key} -->", f"### {title}", "", "| figure | found | goal | met |", "|---|---|---|---|", *rows, ""]
    )


def cell(text: object) -> str:
    """`text` as a table's cell may hold it."""
    return str(text).replace("|", "\\|").replace("\n", " ")


def kept(page: str, key: str) -> str:
    """The section that a page has already, or nothing."""
    match = re.search(rf"\n<!-- {key} -->.*?(?=\n<!-- |\Z)", page, re.DOTALL)
    return match[0].rstrip() + "\n" if match else ""


def fault_table() -> str:
    """Every fault, a row each."""
    from scripts.ads_figures_faults import table

    rows = []
    for fault, gates in table():
        seen = "yes" if fault.gate in gates else f"by {', '.join(gates)}" if gates else f"**no**: {cell(fault.missed)}"
        rows.append(f"| {fault.part} | {cell(fault.name)} | {fault.scenario} | `{fault.gate}` | {seen} |")
    return FAULTS + "\n".join(rows) + "\n"


if __name__ == "__main__":
    main()
