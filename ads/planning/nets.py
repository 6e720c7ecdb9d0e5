"""The nets of the behaviour: data only. Facts are made and places act in ads.planning.behaviour."""

from __future__ import annotations

from ads.planning.petri_net import Net, Transition

MAIN = Net(
    name="main",
    initial=("start",),
    actions={
        "start": "stand until the car knows where it is",
        "drive": "follow the path; the other nets run",
        "emergency": "brake as hard as a collision ahead needs",
        "arrived": "stand at the goal",
    },
    transitions=(
        Transition("localised", ("start",), ("drive",), when=("located",)),
        Transition("danger", ("drive",), ("emergency",), when=("danger",)),
        Transition("averted", ("emergency",), ("drive",), when=("averted",), unless=("danger",)),
        Transition("arrive", ("drive",), ("arrived",), when=("at_goal",)),
        Transition("set_off", ("arrived",), ("drive",), unless=("at_goal",)),
    ),
)

LIGHT = Net(
    name="light",
    initial=("go",),
    actions={"go": "nothing", "stop": "stop at the signal"},
    transitions=(
        Transition("turns_red", ("go",), ("stop",), when=("light_stop",)),
        Transition("turns_green", ("stop",), ("go",), unless=("light_stop",)),
    ),
    parent="main.drive",
)

CROSSING = Net(
    name="crossing",
    initial=("clear",),
    actions={
        "clear": "nothing",
        "approach": "crossing speed until the crossing is passed",
        "stop": "stop before the crossing and wait",
    },
    transitions=(
        Transition("near", ("clear",), ("approach",), when=("crossing_near",)),
        Transition("passed", ("approach",), ("clear",), unless=("crossing_near",)),
        Transition("occupied", ("approach",), ("stop",), when=("crossing_occupied",)),
        Transition("free", ("stop",), ("approach",), unless=("crossing_occupied",)),
    ),
    parent="main.drive",
)

JUNCTION = Net(
    name="junction",
    initial=("clear",),
    actions={
        "clear": "nothing",
        "approach": "look who comes; slower at a sign",
        "give_way": "stop before the way of who goes first, or at the line of the sign, and wait",
    },
    transitions=(
        Transition("near", ("clear",), ("approach",), when=("junction_near",)),
        Transition("passed", ("approach",), ("clear",), unless=("junction_near",)),
        Transition("yield", ("approach",), ("give_way",), when=("junction_taken",)),
        Transition("free", ("give_way",), ("approach",), unless=("junction_taken",)),
    ),
    parent="main.drive",
)

FOLLOWING = Net(
    name="following",
    initial=("free",),
    actions={"free": "nothing", "follow": "keep distance to what is ahead in the path"},
    transitions=(
        Transition("close_up", ("free",), ("follow",), when=("lead",)),
        Transition("lost", ("follow",), ("free",), unless=("lead",)),
    ),
    parent="main.drive",
)

OVERTAKING = Net(
    name="overtaking",
    initial=("keep",),
    actions={
        "keep": "nothing",
        "wait": "approach the obstacle and stop behind it",
        "out": "path around the obstacle, overtaking speed",
        "beside": "as out, alongside the obstacle: no way back",
        "back": "path back to the lane, no lower speed any more",
        "abort": "path back behind the obstacle, stop there",
    },
    transitions=(
        Transition("blocked", ("keep",), ("wait",), when=("obstacle",)),
        Transition("cleared", ("wait",), ("keep",), unless=("obstacle",)),
        Transition("start", ("wait",), ("out",), when=("obstacle", "in_range", "gap_free", "way_around")),
        Transition("alongside", ("out",), ("beside",), when=("beside",)),
        Transition("give_up", ("out",), ("abort",), when=("conflict",), unless=("beside",)),
        Transition("retry", ("abort",), ("wait",), when=("in_lane",)),
        Transition("retry_from_rest", ("abort",), ("wait",), when=("standing",)),
        Transition("passed", ("beside",), ("back",), when=("passed",)),
        Transition("done", ("back",), ("keep",), when=("in_lane",)),
    ),
    parent="main.drive",
)

NETS: tuple[Net, ...] = (MAIN, LIGHT, CROSSING, JUNCTION, FOLLOWING, OVERTAKING)
