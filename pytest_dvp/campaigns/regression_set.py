"""A small set of drives that stands for a campaign: those that a stack that became worse breaks first."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pytest_dvp.campaigns.store import EXCLUDED, Row
from pytest_dvp.campaigns.summary import cluster_name

FOLDER = "regression"
CASES = 20  # in a set, unless asked: minutes of CI
DATE = "1970-01-01T00:00:00"  # a file must state one, and the same rows make the same file on any day
FAILURES = 0.25  # of the set at most: one of each kind of failure, the most frequent first
APART = 0.5  # of the way between neighbours on a grid of as many drives: nearer, two drives tell the same
BOUNDARY = 0.75  # of the set, with the failures: passes with the least margins; the rest is spread


def regression_set(rows: Sequence[Row], count: int) -> list[Row]:
    """Up to `count` drives of one scenario: a failure of each kind, the passes nearest to each gate, and some spread.

    Of a kind of failure it is the drive in its middle. Passes are taken gate by gate in turn, the least objective
    first, but none nearer to one that was taken than APART. The same rows give the same set.
    """
    judged = sorted(
        (row for row in rows if row.verdict != EXCLUDED and row.objective is not None), key=lambda row: row.key
    )
    if len(judged) <= count:
        return judged
    places = _places(judged)
    apart = APART * len(judged) ** (-1.0 / places.shape[1])
    taken = _middles(judged, places)[: max(1, round(FAILURES * count))]
    passed = [k for k, row in enumerate(judged) if row.verdict == "PASS"]
    by_gate: dict[str, list[int]] = {}
    for k in sorted(passed, key=lambda k: (judged[k].objective, judged[k].key)):
        by_gate.setdefault(judged[k].gate, []).append(k)
    while any(by_gate.values()) and len(taken) < round(BOUNDARY * count):
        for near in by_gate.values():
            while near and len(taken) < round(BOUNDARY * count):
                k = near.pop(0)
                if not taken or np.abs(places[taken] - places[k]).max(axis=1).min() >= apart:
                    taken.append(k)
                    break
    while len(taken) < count:  # the one that is farthest from all that are taken
        rest = [k for k in passed if k not in taken] or [k for k in range(len(judged)) if k not in taken]
        away = [float(np.abs(places[taken] - places[k]).max(axis=1).min()) if taken else 1.0 for k in rest]
        taken.append(rest[int(np.argmax(away))])
    return [judged[k] for k in taken]


def write_regression_set(rows: Sequence[Row], folder: Path, name: str) -> Path:
    """Write drives of one scenario as a parameter distribution into a folder: each is a case for pytest and `dvp run`.
    name: what the file's name begins with.

    The gates of the scenario judge it. Returns the file. Raises WriteError if it cannot be written.
    """
    from openscenario.model import distributions as d
    from openscenario.model.catalogs import ParameterAssignment
    from openscenario.model.declarations import FileHeader
    from openscenario.write import write_distribution

    scenario = Path(rows[0].scenario).resolve()
    sets = tuple(
        d.ParameterValueSet(tuple(ParameterAssignment(name, value) for name, value in row.parameters.items()))
        for row in rows
    )
    many = d.DeterministicMultiParameterDistribution(d.ValueSetDistribution(sets))
    varied = d.ParameterValueDistribution(d.ScenarioFile(scenario.name, scenario), d.Deterministic((many,)))
    target = folder / f"{name}-regression.xosc"
    folder.mkdir(parents=True, exist_ok=True)
    failed = sum(row.failed for row in rows)
    said = f"{len(rows)} drives of a campaign of {scenario.name}, {failed} of which failed then"
    write_distribution(d.DistributionFile(FileHeader(1, 2, DATE, said, "dvp campaign"), varied), target)
    return target


def _middles(rows: Sequence[Row], places: np.ndarray) -> list[int]:
    """Of each kind of failure the drive with the least way to the others; the most frequent kind first."""
    clusters: dict[str, list[int]] = {}
    for k, row in enumerate(rows):
        if row.failed:
            clusters.setdefault(cluster_name(row), []).append(k)
    found = []
    for _, members in sorted(clusters.items(), key=lambda item: (-len(item[1]), item[0])):
        middle = np.median(places[members], axis=0)
        found.append(members[int(np.argmin(np.abs(places[members] - middle).max(axis=1)))])
    return found


def _places(rows: Sequence[Row]) -> np.ndarray:
    """A place 0 to 1 in each parameter (n, m): the rank of a number among those that were driven, or of a word."""
    names = list(rows[0].parameters)
    columns = []
    for name in names:
        texts = [row.parameters.get(name, "") for row in rows]
        try:
            _, ranks = np.unique(np.array([float(text) for text in texts]), return_inverse=True)
        except ValueError:
            _, ranks = np.unique(np.array(texts), return_inverse=True)
        columns.append(ranks / max(int(ranks.max()), 1))
    return np.array(columns).T if columns else np.zeros((len(rows), 1))
