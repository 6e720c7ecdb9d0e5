"""Lists the metrics that a gate may bound, with unit, direction and definition."""

from __future__ import annotations

import argparse
import json
import math
import textwrap

from pytest_dvp.cli.shared.arguments import WrongArgument, add_json

PLACE = 170  # in `dvp --help`
READS_NO_LOG = True

DIRECTION = {True: "bigger is worse", False: "smaller is worse", None: "neither direction is worse"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the names of metrics; none stands for all."""
    parser.add_argument("names", nargs="*", metavar="NAME", help="metrics to list; default: all")
    add_json(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Print metrics with unit and definition. Returns 0; raises WrongArgument for an unknown name."""
    from pytest_dvp.metrics import MetricError, find_metric, known_metrics

    try:
        chosen = [find_metric(name) for name in arguments.names] or [m for _, m in sorted(known_metrics().items())]
    except MetricError as error:
        raise WrongArgument(f"dvp metrics: {error}") from None
    table = [
        {
            "name": metric.name,
            "unit": metric.unit,
            "bigger_is_worse": metric.bigger_is_worse,
            "miss": metric.miss,
            "logs": metric.logs,
            "options": {key: _default(value) for key, value in metric.options.items()},
            "ranges": {key: str(allowed) for key, allowed in metric.ranges.items()},
            "definition": metric.definition,
        }
        for metric in chosen
    ]
    if arguments.json:
        print(json.dumps({"metrics": table}, ensure_ascii=False, default=str))
        return 0
    for metric in chosen:
        two = ", of two logs" if metric.logs == 2 else ""
        miss = "" if metric.miss == "FAIL" else f"; a miss is {metric.miss}"
        print(f"{metric.name} [{metric.unit}], {DIRECTION[metric.bigger_is_worse]}{two}{miss}")
        for paragraph in metric.definition.split("\n\n"):
            print(textwrap.fill(" ".join(paragraph.split()), 100, initial_indent="    ", subsequent_indent="    "))
        ranges = {key: f" ({allowed})" for key, allowed in metric.ranges.items()}
        given = [f"{key} = {_told(v)}{ranges.get(key, '')}" for key, v in metric.options.items()]
        print(*([f"    options: {', '.join(given)}"] if given else []), sep="\n", end="\n" if given else "")
    return 0


def _told(value: object) -> object:
    """A default as the listing names it."""
    from pytest_dvp.metrics.metric import REQUIRED

    return "(must be given)" if value is REQUIRED else "undeclared" if _default(value) is None else value


def _default(value: object) -> object:
    """A default as JSON can hold it: None for an option without one, and for one that has to be declared (NaN)."""
    from pytest_dvp.metrics.metric import REQUIRED

    undeclared = isinstance(value, float) and math.isnan(value)
    return None if value is REQUIRED or undeclared else value
