"""What a panel of the page of a run is, and how those of this folder are found and drawn.

A panel is a file with `PLACE`, a number that says where on the page it stands (smaller comes first), `values(run)`,
what its template is filled with or None where there is nothing to show, and `TEMPLATE`, Jinja text that escapes all it
is given. A button `<button class="jump" data-t="12.5" data-object="">` leads to that moment. `STYLE`, CSS text, is
optional.
"""

from __future__ import annotations

import functools
import importlib
import pkgutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any

from markupsafe import Markup
from numpy import float64
from numpy.typing import NDArray

from reports.templating import environment
from reports.verdicts import Row, pretty_unit


@dataclass(frozen=True, slots=True)
class Run:
    """What a panel may show of a run.

    result, columns, objects, events, meta: as in `reports.html.write_run_report`; rows: the verdicts, worst first;
    nets: drawings of the decision nets; data: what the scripts of the page read.
    """

    result: Mapping[str, Any]
    columns: Mapping[str, NDArray[float64]]
    objects: Sequence[Mapping[str, Any]]
    events: Sequence[Mapping[str, Any]]
    meta: Mapping[str, Any]
    rows: Sequence[Row]
    nets: Sequence[Any]
    data: Mapping[str, Any]


@functools.cache
def panels() -> tuple[ModuleType, ...]:
    """The modules of all panels, in the order of the page."""
    names = sorted(
        m.name for m in pkgutil.iter_modules(importlib.import_module(str(__package__)).__path__) if m.name != "panel"
    )
    found = [importlib.import_module(f"{__package__}.{name}") for name in names]
    return tuple(sorted(found, key=lambda module: module.PLACE))


def draw(run: Run) -> Markup:
    """The panels of a run as HTML, with an empty line between two."""
    texts = [_drawn(module, module.values(run)) for module in panels()]
    return Markup("\n".join(texts).removesuffix("\n"))


def styles() -> str:
    """The CSS of all panels that bring some."""
    return "".join(getattr(module, "STYLE", "") for module in panels())


def _drawn(panel: ModuleType, values: Mapping[str, Any] | None) -> str:
    return "" if values is None else _template(panel.TEMPLATE).render(**values) + "\n"


@functools.cache
def _template(text: str) -> Any:
    made = environment()
    made.filters["unit"] = pretty_unit
    made.filters["short"] = lambda value: "–" if value is None else f"{value:.4g}"
    return made.from_string(text)
