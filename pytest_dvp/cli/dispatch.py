"""The commands of `dvp`, their parser, and what becomes of an error.

Exit codes: 0 all PASS, or the question was answered; 1 any other verdict, or something wrong in a file; 2 a wrong
option, or an argument that names nothing of its kind: a missing file, a folder for a file, an unknown effect. Results
go to stdout (with --json one JSON document and nothing else), progress to stderr.
"""

from __future__ import annotations

import argparse
import contextlib
import errno
import functools
import importlib
import io
import json
import os
import pkgutil
import sys
import warnings
from collections.abc import Sequence
from types import ModuleType
from typing import Any, NoReturn

from pytest_dvp.cli.shared.arguments import WrongArgument, add_budget, add_settings, budget_from
from pytest_dvp.logs.budget import in_force
from pytest_dvp.text.errors import SettingError, is_users_mistake
from pytest_dvp.text.spelling import nearest, unknown
from reports.whole_file import WriteError

THREADS = "NUMBA_NUM_THREADS"
"""Environment variable that says in how many threads compiled code may run."""
NO_COMMANDS = ("__main__", "command_line", "dispatch", "shared")


@functools.cache
def commands() -> tuple[ModuleType, ...]:
    """The modules of all commands: every file of this folder, in the order of `dvp --help`.

    A command's module has `add_arguments(parser)`, `execute(arguments)`, a docstring, and `PLACE`, its place in the
    help. `READS_NO_LOG = True` leaves out the options that say how large a log may be; `READS_SCENARIOS = True` adds
    that of files.
    """
    folder = importlib.import_module(str(__package__)).__path__
    names = [module.name for module in pkgutil.iter_modules(folder) if module.name not in NO_COMMANDS]
    found = [importlib.import_module(f"{__package__}.{name}") for name in names]
    return tuple(sorted(found, key=lambda module: (module.PLACE, module.__name__)))


MEANT = {"--out": "--runs", "--output": "--runs", "--log-dir": "--runs", "--report": "--runs"}
"""Options by the names that other commands and tools have for them."""


class Parser(argparse.ArgumentParser):
    """An argument parser whose complaint is one line with the nearest valid option."""

    def error(self, message: str) -> NoReturn:
        """Raises WrongArgument with the complaint of argparse in one line."""
        raise WrongArgument(f"{self.prog}: {message} ({self.prog} --help)")


class Version(argparse.Action):
    """--version: that of the installed package, looked up when it is asked for."""

    def __init__(self, option_strings: Sequence[str], dest: str) -> None:
        super().__init__(option_strings, argparse.SUPPRESS, nargs=0, help="print the version and exit")

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> NoReturn:
        from pytest_dvp import __version__

        print(f"dvp {__version__}")
        parser.exit()


def build_parser() -> argparse.ArgumentParser:
    """The parser of all commands; each command's module sets `function` to what runs it."""
    parser = Parser(prog="dvp", description="Tests driving stacks by OpenSCENARIO files.", allow_abbrev=False)
    parser.add_argument("--version", action=Version)
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND", required=True, parser_class=Parser)
    for module in commands():
        name = module.__name__.rpartition(".")[2]
        summary = (module.__doc__ or "").split("\n")[0]
        command = subparsers.add_parser(name, help=summary, description=module.__doc__, allow_abbrev=False)
        _add_arguments(module, command)
        command.set_defaults(function=module.execute)
    return parser


def _add_arguments(module: Any, parser: argparse.ArgumentParser) -> None:
    module.add_arguments(parser)
    if not getattr(module, "READS_NO_LOG", False):
        add_budget(parser)
    elif getattr(module, "READS_SCENARIOS", False):
        add_settings(parser, ("max-file-bytes",))


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command; returns the exit code. A user's mistake is one line on stderr, never a traceback."""
    words = list(sys.argv[1:] if argv is None else argv)
    if argv is None and not sys.warnoptions:  # what numpy thinks of a NaN in a user's log is nothing to a user
        warnings.simplefilter("ignore", RuntimeWarning)
    _spell_what_cannot_be_shown()
    try:
        _check_threads(os.environ.get(THREADS) or "1")
        arguments = _parse(words)
    except SystemExit as done:  # --help
        return int(done.code or 0)
    except WrongArgument as error:
        return _complain(words, str(error), 2)
    try:
        with in_force(budget_from(arguments)):
            code = int(arguments.function(arguments))
        sys.stdout.flush()  # here, where a full disk behind it can still be told
        return code
    except SystemExit as done:  # of a file of effects, a model, a package: its code would look like a verdict
        return _complain(words, f"dvp: a file that was loaded ended the program: sys.exit({done.code!r})", 1)
    except (WrongArgument, SettingError) as error:
        return _complain(words, str(error), 2)
    except KeyboardInterrupt as interrupt:
        return _complain(words, f"dvp: {interrupt}" if str(interrupt) else "dvp: interrupted", 130)
    except BrokenPipeError:  # who read it has seen enough
        _leave_stdout()
        return 1
    except WriteError as error:
        return _complain(words, str(error), 2)
    except OSError as error:
        if error.filename is None:
            _leave_stdout()
        code = 2 if error.errno in (errno.ENAMETOOLONG, errno.ELOOP) else 1  # an argument that can name nothing
        return _complain(words, f"{error.filename or 'the output'}: {error.strerror or error}", code)
    except Exception as error:
        if not is_users_mistake(error):
            raise
        return _complain(words, str(error), 1, [f.as_dict() for f in getattr(error, "findings", ())])


def _check_threads(told: str) -> None:
    """Raises WrongArgument: numba would end with a traceback when it is imported."""
    if not (told.isdecimal() and int(told) > 0):
        raise WrongArgument(f"{THREADS}: must be a whole number of threads, 1 or more (found {told!r})")


def _spell_what_cannot_be_shown() -> None:
    """A file name or a sign that the terminal's encoding does not have is shown by its number, in place of no text."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def _leave_stdout() -> None:
    """What is left for a stdout that takes no more is dropped: Python would try, and complain, once more at its end."""
    with contextlib.suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


def _parse(words: list[str]) -> argparse.Namespace:
    names = [module.__name__.rpartition(".")[2] for module in commands()]
    if words and not words[0].startswith("-") and words[0] not in names:
        raise WrongArgument(f"dvp: {unknown('command', words[0], names)} (dvp --help)")
    parser = build_parser()
    arguments, rest = parser.parse_known_args(words)
    if rest:
        command = f"dvp {arguments.command}"
        options = [
            option
            for module in commands()
            if module.__name__.endswith(f".{arguments.command}")
            for option in _options(module)
        ]
        word = rest[0].partition("=")[0]
        near = (MEANT.get(word) if MEANT.get(word) in options else nearest(word, options)) if word[0] == "-" else None
        hint = f", did you mean {near}?" if near else ""
        raise WrongArgument(f"{command}: unknown argument {rest[0]!r}{hint} ({command} --help)")
    return arguments


def _options(module: Any) -> list[str]:
    probe = argparse.ArgumentParser(add_help=False)
    _add_arguments(module, probe)
    return [option for action in probe._actions for option in action.option_strings]


def _complain(words: Sequence[str], message: str, code: int, findings: Sequence[dict[str, Any]] = ()) -> int:
    print(message, file=sys.stderr)
    if "--json" in words:
        print(json.dumps({"error": message, "findings": list(findings)}, ensure_ascii=False))
    return code
