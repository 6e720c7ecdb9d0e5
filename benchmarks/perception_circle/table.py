"""The circles as a table."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.perception_circle.circle import Circle

BEGIN, END = "<!-- circle -->", "<!-- /circle -->"
CLOSE = 0.1  # of the car's value: what counts as the same
LEAST = (0.01, 0.02, 0.02)  # recall [-], position error [m], latency [s]: smaller differences are none
HEAD = (
    "| hidden in the car | the twin was given | recall: car, twin before, after | position error [m] | latency [s] "
    "| within 10 % |\n|---|---|---|---|---|---|"
)


def table(done: Sequence[Circle]) -> str:
    """A row a circle, as Markdown."""
    return "\n".join([HEAD, *map(_row, done)])


def alike(one: Circle) -> tuple[bool, bool, bool]:
    """Whether recall, position error and latency of the extended twin are within 10 % of the car's, or within LEAST."""
    pairs = (
        (one.car.recall, one.after.recall),
        (one.car.position_error, one.after.position_error),
        (one.car.latency, one.after.latency),
    )
    return tuple(  # type: ignore[return-value]
        a is not None and b is not None and abs(a - b) <= max(CLOSE * abs(a), least)
        for (a, b), least in zip(pairs, LEAST, strict=True)
    )


def _row(one: Circle) -> str:
    told = []
    for key in ("recall", "position_error", "latency"):
        told.append(", ".join(_figure(getattr(s, key)) for s in (one.car, one.before, one.after)))
    names = ("recall", "position error", "latency")
    missed = [name for name, same in zip(names, alike(one), strict=True) if not same]
    return f"| {_effects(one.hidden)} | {_effects(one.found)} | {' | '.join(told)} | " + (
        f"not {', '.join(missed)} |" if missed else "yes |"
    )


def _effects(values: object) -> str:
    assert isinstance(values, dict)
    told = [
        f"`{name}` " + ", ".join(f"{key} {value:.3g}" for key, value in keys.items() if _on(name, key, value))
        for name, keys in values.items()
    ]
    return "; ".join(told) or "nothing"


def _on(name: str, key: str, value: float) -> bool:
    from vehicle.model.effect_catalogue import find_effect

    return value != find_effect(name).key(key).neutral


def _figure(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}"


def written_into(page: str, new: str) -> str:
    """The page with the table between its marks replaced. Raises ValueError without marks."""
    before, begin, rest = page.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise ValueError(f"the page has no {BEGIN} ... {END}")
    return f"{before}{begin}\n{new}\n{end}{after}"
