"""The files of `reports/templates` and how pages are made from them: the same rules for every page."""

from __future__ import annotations

from functools import cache
from importlib.resources import files

from jinja2 import Environment, PackageLoader, StrictUndefined


@cache
def asset(name: str) -> str:
    """The text of a file of `reports/templates`."""
    return files("reports").joinpath("templates", name).read_text(encoding="utf-8")


def environment() -> Environment:
    """Templates that escape what they are given and fail on a name that they are not; filters are the page's own."""
    return Environment(
        loader=PackageLoader(__package__),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
