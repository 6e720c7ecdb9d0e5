"""What to write where a project's package of one of our names is taken for ours: one phrase, with both places."""

from __future__ import annotations

import sys

from pytest_dvp.rooms.side_by_side import PACKAGES, PREFIX, is_apart

PAGE = "docs/decisions/own-packages.md"


def import_advice(error: BaseException) -> str:
    """For an import that found the project's package of one of our names and not in it what was asked for: where that
    package lies, and how ours is imported. Empty for any other error, and where ours have their plain names."""
    name = getattr(error, "name", None) if isinstance(error, ImportError) else None
    top = str(name or "").partition(".")[0]
    if top not in PACKAGES or not is_apart():
        return ""
    return f"; {top!r} is {file_of(top)} here, and ours is imported by `{_import_of(str(name))} ...` ({PAGE})"


def other_class(found: type, expected: type) -> str:
    """For an object of a class that only has the name of ours: both files, and how ours is imported."""
    plain = expected.__module__.removeprefix(PREFIX)
    return (
        f"a {found.__name__} of {file_of(found.__module__)}, expected that of {file_of(expected.__module__)}: "
        f"`{_import_of(plain)} {expected.__name__}` ({PAGE})"
    )


def file_of(module: str) -> str:
    """The file of a loaded module, the folder of one without a file; its name if it has neither."""
    loaded = sys.modules.get(module)
    places = [getattr(loaded, "__file__", None), *getattr(loaded, "__path__", ())]
    return next((str(place) for place in places if place), module)


def _import_of(name: str) -> str:
    return f"from {PREFIX}{name} import"
