"""The options that a printed command takes over from the one that prints it, so that it runs as it stands."""

from __future__ import annotations

import argparse


def forwarded_options(arguments: argparse.Namespace) -> list[str]:
    """How the logs are read and which effects there are: --map, --msg and --effects, as words of a command line."""
    words = ["--map", arguments.map] if arguments.map else []
    for option, values in (("--msg", arguments.msg), ("--effects", arguments.effects)):
        words += [word for text in values for word in (option, text)]
    return words
