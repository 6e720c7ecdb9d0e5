"""Writes what is generated from RunSpec:  python -m scripts.make_run_options

These are pytest_dvp/drive/run_options.py (the keywords of `pytest_dvp.run()` with their types), the list of options in
the docstring of `run()`, and the page docs/options.md. A test says so when one of them is behind.
"""

from __future__ import annotations

import textwrap
from pathlib import Path

from pytest_dvp.drive.option import STAGES, Kind, Setting
from pytest_dvp.drive.run_spec import OPTIONS

ROOT = Path(__file__).resolve().parents[1]
TYPES = ROOT / "pytest_dvp" / "drive" / "run_options.py"
RUN = ROOT / "pytest_dvp" / "drive" / "run.py"
PAGE = ROOT / "docs" / "options.md"
BEGIN, END = "in the loop and judge it.\n\n", "\n    Raises ScenarioError"
WIDTH = 120  # columns of a source file
NAME = 17  # columns of a keyword and the space behind it, in the docstring

TYPES_HEAD = '''\
"""RunOptions: the keywords of `pytest_dvp.run()`. Made by `python -m scripts.make_run_options` from RunSpec."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict

if TYPE_CHECKING:
    from openscenario.road.repairs import Roads
    from openscenario.storyboard.reading import Reading
    from pytest_dvp.drive.chosen_stack import Ads, DriverFactory


class RunOptions(TypedDict, total=False):
    """What `pytest_dvp.run()` can be told; what is left out has its default."""

'''

PAGE_HEAD = """\
# Options of a run

Every option once, with each way to set it. The command line comes before the environment, the environment before the
ini file; the keywords of `pytest_dvp.run()`, and of the fixture `run`, hold for one call. `dvp` reads the keys of the
file that configures pytest, and `--no-ini` leaves them out. In the environment, lists are separated like `PATH`, and
assignments by spaces. This page is made by `python -m scripts.make_run_options` from
`pytest_dvp/drive/run_spec.py`, where an option is declared by one field.

"""

OF_READING = "\nBesides pytest, every `dvp` command that reads a log has these:\n\n"
OF_PYTEST = "\nOnly the pytest plugin has these:\n\n"
OF_PYTHON = "\nOnly `pytest_dvp.run()` has these:\n\n"

_ALLOWED: dict[Kind, str] = {
    "ads": "[a name](your-ads.md)",
    "assignments": "any number of assignments",
    "delay": "`SECONDS[+-JITTER][,drop=SHARE]`",
    "file": "a file",
    "files": "any number of files",
    "flag": "yes or no",
    "logs": "any number of logs and run folders",
    "new_file": "a file that is written",
    "path": "a folder, which is made",
    "paths": "any number of folders",
    "size": "bytes, as `2GB`",
    "str": "a text",
}


def types() -> str:
    """The file of RunOptions."""
    lines = []
    for keyword, type_, meaning in _keywords():
        text = textwrap.wrap(f'"""{meaning}."""', WIDTH - 4, break_long_words=False, break_on_hyphens=False)
        lines += [f"    {keyword}: {type_}", *(f"    {line}" for line in text)]
    return TYPES_HEAD + "\n".join(lines) + "\n"


def docstring() -> str:
    """The options in the docstring of `run()`."""
    lines: list[str] = []
    for keyword, _, meaning in _keywords():
        wrapped = textwrap.wrap(meaning, WIDTH - 4 - NAME, break_long_words=False, break_on_hyphens=False)
        lines += [f"    {keyword:<{NAME}}{wrapped[0]}", *(f"    {'':{NAME}}{line}" for line in wrapped[1:])]
    return "\n".join(lines) + "\n"


def run_with_docstring(source: str) -> str:
    """The source of `run()` with its options as they are now."""
    head, _, rest = source.partition(BEGIN)
    _, _, tail = rest.partition(END)
    return f"{head}{BEGIN}{docstring()}{END}{tail}"


def page() -> str:
    """docs/options.md."""
    by_home = {home: [one for one in OPTIONS if one.home == home] for home in ("run", "reading", "pytest", "python")}
    return (
        PAGE_HEAD
        + _table(by_home["run"])
        + OF_READING
        + _table(by_home["reading"])
        + OF_PYTEST
        + _table(by_home["pytest"])
        + OF_PYTHON
        + _table(by_home["python"])
    )


def _table(settings: list[Setting]) -> str:
    head = ("`dvp`", "pytest", "ini key", "variable", "`run()`", "unit", "default", "allowed", "meaning")
    rows = [head, tuple("---" for _ in head), *map(_row, settings)]
    return "".join(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in row)} |\n" for row in rows)


def _row(setting: Setting) -> tuple[str, ...]:
    outside = setting.home != "python"
    return (
        f"`--{setting.name}`" if setting.home in ("run", "reading") else "",
        f"`--dvp-{setting.name}`" if outside else "",
        f"`{setting.ini}`" if outside else "",
        f"`{setting.environment}`" if outside else "",
        ", ".join(f"`{keyword}`" for keyword, *_ in setting.keywords),
        setting.unit,
        _default(setting),
        _allowed(setting),
        _meaning(setting, default=False),
    )


def _allowed(setting: Setting) -> str:
    if setting.allowed or setting.choices:
        return setting.allowed or ", ".join(setting.choices)
    if setting.kind in ("int", "float"):
        number = "whole number" if setting.kind == "int" else "number"
        return number if setting.least is None else f"{number} >= {setting.least:g}"
    return _ALLOWED[setting.kind]


def _default(setting: Setting) -> str:
    """The default, if it is one value; the meaning tells the others."""
    if setting.default is None or setting.default == ():
        return ""
    if setting.kind == "flag":
        return "no"
    return f"{setting.default:g}" if setting.kind == "float" else str(setting.default)


def _meaning(setting: Setting, default: bool = True) -> str:
    parts = [setting.help]
    if setting.stages != STAGES and "stage" not in setting.help:
        parts = [f"{'stages' if len(setting.stages) > 1 else 'stage'} {' and '.join(setting.stages)}: {setting.help}"]
    parts += [setting.more] if setting.more else []
    if default and setting.default not in (None, ()) and "default" not in setting.help:
        parts.append(f"default: {setting.default if setting.kind == 'flag' else _default(setting)}")
    return "; ".join(parts)


def _keywords() -> list[tuple[str, str, str]]:
    """Each keyword of `run()` with its type and its meaning."""
    return [
        (keyword, type_, own or _meaning(setting)) for setting in OPTIONS for keyword, type_, own in setting.keywords
    ]


def main() -> None:
    TYPES.write_text(types(), encoding="utf-8")
    RUN.write_text(run_with_docstring(RUN.read_text(encoding="utf-8")), encoding="utf-8")
    PAGE.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
