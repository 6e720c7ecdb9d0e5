"""One minimal reproducer for each kind of failure: as few changed parameters as fail in the same way."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pytest_dvp.campaigns.campaign import Campaign
from pytest_dvp.campaigns.parameter_space import Values
from pytest_dvp.campaigns.store import SHRINKING, Row
from pytest_dvp.campaigns.summary import cluster_name

FOLDER = "reproducers"
MOST = 8  # kinds of failure of one scenario that get a reproducer, the most frequent first
HALVINGS = 5  # steps back towards the nominal value: what is left of the way is known to 3 %


@dataclasses.dataclass(frozen=True)
class Reproducer:
    """A failure that nothing can be taken from.

    cluster   what happened: the gate, and with whom; count: drives of the campaign that failed so
    row       the drive of the reproducer; changed: its parameters that are not nominal
    file      the scenario as a file with these values; command: drives it again
    """

    cluster: str
    count: int
    row: Row
    changed: Values
    nominal: Values
    file: Path
    command: str

    def sentence(self) -> str:
        """`max_jerk <= 4 m/s^3 breaks with ego_speed = 5.9 (nominal 5.5) alone.`"""
        if not self.changed:
            return f"{self.cluster} breaks at the nominal values."
        parts = [f"{name} = {value} (nominal {self.nominal[name]})" for name, value in self.changed.items()]
        alone = "; with any one of them back at its nominal value it does not break" if len(parts) > 1 else " alone"
        return f"{self.cluster} breaks with {', '.join(parts)}{alone}."

    def as_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "cluster": self.cluster, "count": self.count, "key": self.row.key, "changed": dict(self.changed),
            "sentence": self.sentence(), "file": str(self.file), "command": self.command, "message": self.row.message,
        }  # fmt: skip


def reproducers(campaign: Campaign, rows: Sequence[Row], name: str) -> list[Reproducer]:
    """A reproducer of each cluster among the failures of a campaign, written into its folder; the drives that this
    takes are rows of the store as well, so that the same again drives nothing.
    name: what the names of the files begin with.

    Raises WriteError if a file cannot be written.
    """
    clusters: dict[str, list[Row]] = {}
    for row in rows:
        if row.failed:
            clusters.setdefault(cluster_name(row), []).append(row)
    ranked = sorted(clusters.items(), key=lambda item: (-len(item[1]), item[0]))[:MOST]
    found = []
    for cluster, failures in ranked:
        start = min(failures, key=lambda row: (_changes(campaign, row), row.key))
        row = smallest(campaign, start)
        changed = changed_values(campaign, row)
        target = campaign.store.folder / FOLDER / f"{name}-{_slug(cluster)}.xosc"
        command = _write(campaign, row.parameters, target)
        found.append(Reproducer(cluster, len(failures), row, changed, campaign.space.nominal, target, command))
    return found


def smallest(campaign: Campaign, row: Row) -> Row:
    """A drive that fails in the same way, in which no single parameter can go back to its nominal value.

    Parameters go back one by one until none can; what is left is moved towards nominal by halving, and tried again.
    """
    row = _without(campaign, row)
    for axis in campaign.space.axes:
        if axis.count is None and any(row.parameters[n] != v for n, v in axis.nominal.items()):
            row = _nearer(campaign, row, axis.name, axis.nominal[axis.name])
    return _without(campaign, row)  # nearer to nominal, another parameter may no longer be needed


def changed_values(campaign: Campaign, row: Row) -> Values:
    """The parameters of a drive that are not nominal."""
    nominal = campaign.space.nominal
    return {name: value for name, value in row.parameters.items() if value != nominal[name]}


def _without(campaign: Campaign, row: Row) -> Row:
    while True:
        tries = [
            {**row.parameters, **axis.nominal}
            for axis in campaign.space.axes
            if any(row.parameters[name] != value for name, value in axis.nominal.items())
        ]
        fewer = [each for each in campaign.rows_of(tries, SHRINKING) if _same(each, row)]
        if not fewer:
            return row
        row = min(fewer, key=lambda each: (_changes(campaign, each), each.key))


def _nearer(campaign: Campaign, row: Row, name: str, nominal: str) -> Row:
    whole = row.parameters[name].lstrip("-").isdigit() and nominal.lstrip("-").isdigit()
    far, near = float(row.parameters[name]), float(nominal)
    for _ in range(HALVINGS):
        middle = 0.5 * (far + near)
        value = _typed(middle, abs(far - near), whole)
        if value in (row.parameters[name], nominal):
            break
        tried = campaign.rows_of([{**row.parameters, name: value}], SHRINKING)[0]
        if _same(tried, row):
            row, far = tried, float(value)
        else:
            near = float(value)
    return row


def _typed(value: float, step: float, whole: bool) -> str:
    """A value with as few digits as the step needs."""
    import math

    from openscenario.values import spelled

    return spelled(round(value) if whole else round(value, max(1 - math.floor(math.log10(step)), 0)))


def _same(one: Row, other: Row) -> bool:
    return one.failed and cluster_name(one) == cluster_name(other)


def _changes(campaign: Campaign, row: Row) -> tuple[int, float]:
    """How many parameters differ from nominal, and by how much of their ranges in sum."""
    space = campaign.space
    far = [abs(axis.share_of(row.parameters) - axis.share_of(axis.nominal)) for axis in space.axes]
    return len(changed_values(campaign, row)), sum(far)


def _write(campaign: Campaign, values: Values, target: Path) -> str:
    """Write a variant as a scenario of its own; returns the command that drives it."""
    from openscenario.read import read_scenario
    from openscenario.write import write_scenario
    from pytest_dvp.drive.request import request_of
    from pytest_dvp.drive.result import replay_command

    source = campaign.space.scenario
    options = {**campaign.options, "parameters": {**campaign.options.get("parameters", {}), **values}}
    asked = request_of(source, options)
    scenario = read_scenario(source, library=asked.spec.library, rootdir=asked.rootdir, parameters=asked.parameters)
    target.parent.mkdir(parents=True, exist_ok=True)
    write_scenario(scenario, target)
    gates = asked.spec.gates or source.with_name(f"{source.stem}.gates.toml")
    library = (*asked.spec.library, source.parent.resolve())
    # A worker drives the stack inside itself; a stack that ends its process would end a replay without a word.
    spec = dataclasses.replace(
        asked.spec, gates=gates if gates.is_file() else None, library=library, stack_process=None
    )  # fmt: skip
    return replay_command(dataclasses.replace(asked, path=target, parameters={}, spec=spec))


def _slug(text: str) -> str:
    return re.sub(r"[^A-Za-z0-9]+", "-", text).strip("-")[:60]
