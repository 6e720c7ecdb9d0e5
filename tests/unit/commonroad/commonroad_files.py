"""Small CommonRoad scenarios, made for the tests: lanelets from their bounds, obstacles from their states."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

Points = Sequence[tuple[float, float]]


def points(bound: Points) -> str:
    return "".join(f"<point><x>{x}</x><y>{y}</y></point>" for x, y in bound)


def lanelet(number: int, left: Points, right: Points, *, more: str = "", kind: str = "urban") -> str:
    return (
        f'<lanelet id="{number}"><leftBound>{points(left)}</leftBound><rightBound>{points(right)}</rightBound>'
        f"{more}<laneletType>{kind}</laneletType></lanelet>"
    )


def after(*ids: int) -> str:
    return "".join(f'<successor ref="{each}"/>' for each in ids)


def before(*ids: int) -> str:
    return "".join(f'<predecessor ref="{each}"/>' for each in ids)


def beside(side: str, number: int, direction: str = "same") -> str:
    return f'<adjacent{side} ref="{number}" drivingDir="{direction}"/>'


def state(step: int, x: float, y: float, h: float = 0.0, v: float = 0.0, tag: str = "state") -> str:
    return (
        f"<{tag}><position><point><x>{x}</x><y>{y}</y></point></position>"
        f"<orientation><exact>{h}</exact></orientation><time><exact>{step}</exact></time>"
        f"<velocity><exact>{v}</exact></velocity></{tag}>"
    )


BOX = "<shape><rectangle><length>4.5</length><width>1.8</width></rectangle></shape>"


def dynamic(number: int, states: Iterable[tuple[int, float, float, float, float]], kind: str = "car") -> str:
    first, *rest = states
    more = "".join(state(*each) for each in rest)
    return (
        f'<dynamicObstacle id="{number}"><type>{kind}</type>{BOX}{state(*first, tag="initialState")}'
        f"<trajectory>{more}</trajectory></dynamicObstacle>"
    )


def static(number: int, x: float, y: float, kind: str = "parkedVehicle") -> str:
    return (
        f'<staticObstacle id="{number}"><type>{kind}</type>{BOX}{state(0, x, y, tag="initialState")}</staticObstacle>'
    )


def problem(x: float, y: float, v: float, goal: str, last: int = 200) -> str:
    return (
        f'<planningProblem id="900">{state(0, x, y, 0.0, v, "initialState")}<goalState><position>{goal}</position>'
        f"<time><intervalStart>0</intervalStart><intervalEnd>{last}</intervalEnd></time></goalState></planningProblem>"
    )


PLACE = (
    "<location><geoNameId>-999</geoNameId><gpsLatitude>999</gpsLatitude><gpsLongitude>999</gpsLongitude></location>"
    "<scenarioTags><urban/></scenarioTags>"
)


def scenario(*parts: str, version: str = "2020a") -> str:
    return (
        f'<?xml version="1.0"?><commonRoad commonRoadVersion="{version}" benchmarkID="DEU_Own-1_1_T-1" '
        f'timeStepSize="0.1" author="" affiliation="" source="">{PLACE}{"".join(parts)}</commonRoad>'
    )


def straight(x0: float, x1: float, y: float, step: float = 10.0) -> list[tuple[float, float]]:
    count = max(round((x1 - x0) / step), 1)
    return [(x0 + n * (x1 - x0) / count, y) for n in range(count + 1)]


def two_lanes() -> list[str]:
    """Two lanes of 3.5 m from x = 0 to 200 m, one behind the other in two pieces, and one of the other direction.

    Lanelets 1 (left) and 2 (right), 3 and 4 behind them; 5 beside 1, driven the other way.
    """
    return [
        lanelet(
            1, straight(0, 100, 0.0), straight(0, 100, -3.5),
            more=after(3) + beside("Left", 5, "opposite") + beside("Right", 2),
        ),
        lanelet(2, straight(0, 100, -3.5), straight(0, 100, -7.0), more=after(4) + beside("Left", 1)),
        lanelet(3, straight(100, 200, 0.0), straight(100, 200, -3.5), more=before(1) + beside("Right", 4)),
        lanelet(4, straight(100, 200, -3.5), straight(100, 200, -7.0), more=before(2) + beside("Left", 3)),
        lanelet(5, straight(0, 100, 0.0)[::-1], straight(0, 100, 3.5)[::-1], more=beside("Left", 1, "opposite")),
    ]  # fmt: skip
