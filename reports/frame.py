"""The frame of every page: its scripts, its policy, its data, and where the library that draws comes from.

The library is 4.8 MB. Reports of runs share one copy, `RUNS/assets/plotly-VERSION.min.js` beside the run folders; a
page that stands alone carries it compressed. Nothing else is ever loaded. The policy allows our own scripts by their
hashes, and the shared library by a nonce: `file:` addresses have no origin that 'self' could mean. The nonce is a hash
of all data in the page, so no text from a user's file can hold it.
"""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from typing import Any

from markupsafe import Markup

from reports.embed import compact, embed, packed
from reports.templating import asset
from reports.whole_file import write_whole

ASSETS = "assets"  # folder of the library in a folder of runs


def frame(
    data: Mapping[str, Any], scripts: Sequence[str], styles: Sequence[str], library: str | None = None
) -> dict[str, Any]:
    """What templates/page.html needs.

    data: JSON-able, read by the scripts; scripts, styles: files of reports/templates; library: address of the library
    relative to the page, None to carry it in the page.
    """
    text = embed(compact(data))
    ours = [asset(name) for name in ("theme.js", *scripts)]
    allowed = [f"'sha256-{_digest(script)}'" for script in (*ours, *([plotly_js()] if library is None else []))]
    nonce = ""
    if library is not None:
        nonce = hashlib.sha256((library + text).encode()).hexdigest()
        allowed.append(f"'nonce-{nonce}'")
    return {
        "data": Markup(text),
        "style": Markup("".join(asset(name) for name in styles)),
        "scripts": [Markup(script) for script in ours],
        "policy": " ".join(allowed),
        "library": library,
        "packed_library": packed_plotly() if library is None else "",
        "nonce": nonce,
    }


def place_library(runs: Path) -> None:
    """Put the library into a folder of runs if it is not there.

    Workers of a session may do it at once: the file appears whole, whoever writes it. Raises WriteError.
    """
    file = runs / ASSETS / library_name()
    content = plotly_js().encode("utf-8")
    try:
        there = file.stat().st_size == len(content)
    except OSError:
        there = False
    if not there:
        file.parent.mkdir(parents=True, exist_ok=True)
        write_whole(file, content)


def has_library(runs: Path) -> bool:
    """Whether a folder of runs shares a library, of this version or another."""
    return any((runs / ASSETS).glob("plotly-*.min.js"))


def library_address() -> str:
    """Where the page of a run folder finds the library of its folder of runs."""
    return f"../{ASSETS}/{library_name()}"


def library_name() -> str:
    """File name of the library that the installed version of plotly brings."""
    return f"plotly-{version('plotly')}.min.js"


@cache
def plotly_js() -> str:
    """plotly.js as the Python package brings it: the full bundle, as it has no smaller one."""
    text = files("plotly").joinpath("package_data", "plotly.min.js").read_text(encoding="utf-8")
    return text.replace("</script", "<\\/script")


@cache
def packed_plotly() -> str:
    """The library for a page that stands alone: 1.9 MB."""
    return packed(plotly_js())


@cache
def _digest(script: str) -> str:
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
