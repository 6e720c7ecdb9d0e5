"""Writes docs/effects.md from the catalogue:  python -m scripts.make_effects_page

The page is text around a table; the table is the catalogue. A test says so when the page is behind.
"""

from __future__ import annotations

from pathlib import Path

from vehicle.model.bus import bus_table
from vehicle.model.car import CAR_DECLARATIONS
from vehicle.model.command_inputs import INPUT_KEYS
from vehicle.model.effect import SLOTS, Effect
from vehicle.model.effect_catalogue import catalogue

PAGE = Path(__file__).resolve().parents[1] / "docs" / "effects.md"

HEAD = """\
# Effects

A vehicle model consists of a base (`kinematic_bicycle`, `dynamic_bicycle`) and of effects that act on it. One compiled
step computes them all: commands -> actuators -> road -> forces -> body -> sensors. An effect at its neutral value
changes nothing. `dvp effects` lists the effects, `dvp effects NAME` describes one, and `--json` is for programs.
`python -m scripts.make_effects_page` writes this page.

## In a model file

```toml
[model]
base = "kinematic_bicycle"
[inputs]
steer = "steer_cmd"
longitudinal = "accel_cmd"
[parameters]
wheelbase = 2.45
[[effect]]
name = "steer_delay"
[effect.parameters.T]
value = 0.21
unit = "s"
```

Tyre effects (marked T) need tyres. With one of them, a kinematic car moves as a single-track car with stiff axles
(cornering stiffness 48/rad of their load), unless `cornering_stiffness_front` and `_rear` are given. These axles steer
neutrally, so `understeer` with K gives r = v d/(L + K v^2). Below 1 m/s every car is kinematic.

## Assumptions of an open-loop run

- A command logged at t holds from t to the next stamp; stamps need not be even. A measured input (`steer`, `v`) is
  interpolated linearly between stamps.
- A row shows the motion at its stamp, with the command of that stamp already acting: the ideal car has
  `yaw_rate = v tan(steer_cmd)/wheelbase` and `ax = accel_cmd` in the same row.
- Before the log begins, its first command is assumed to have been held for a long time, so actuators start at rest.
- At the start of a segment, pose and speed are set; delay lines, lags, limits and play continue. A sensor with latency
  gets a past that is moved together with the car.
- The ground is the plane of `road_grade` and `road_bank`, with at most one hill or hollow on it (`road_profile`). An
  open-loop run has no road file, so it contains no other grade that changes along the way. (In a scenario, the twin
  gets the grade from the elevation of the road file.)
- `v` is along the ground and `yaw_rate` about its normal. `x`, `y` and `yaw` are those of a map: on a slope, the way
  ahead is v cos(grade), and the heading changes by yaw_rate cos(bank)/cos(grade).
- A kinematic car is that of textbooks: turning takes nothing from its drive. A real one gives up speed when it turns in
  and gets it back when it turns out, as v^2 (1 + (l_r^2 + I/m) tan(d)^2/L^2) stays: 0.25 % at 0.1 rad of steering, 1 %
  at 0.2, 2.3 % at 0.3, 6.7 % at 0.5. A car with tyres does, above 2 m/s: where tight bends matter, take that.
- `headwind` is only what the wind changes of the drag: give the model an `aero_drag` of at least its `k`. Without one,
  a tail wind takes away a drag that the model does not have, and drives the car on faster than it blows itself.
- The discs of `brake_fade` are cold when a log begins, and a car that stands then has a steering that sticks
  (`steer_sticking`).
- `ax` and `ay` are those at the rear axle; `ax_x` and `ay_x` in `[parameters]` name points ahead of it. This matters
  with tyres: an `ay` at the centre of gravity shows the turn-in differently from one at the rear axle.
  Where the file states no `ay_x`, a diagnosis fits it along, from -0.4 to 1.4 wheelbases.

```python
from vehicle.model.model_file import read_model
from vehicle.model.open_loop import Replay

replay = Replay(read_model("model.toml"), t, {"steer_cmd": steer_cmd, "accel_cmd": accel_cmd})
rows = replay.run({("steer_delay", "T"): 0.21})  # (n, 8): x y yaw v yaw_rate ax ay steer
```

A run of 165 s at 50 Hz takes about 0.5 ms; a changed value adds nothing to it. With the names `"inputs"` and
`"parameters"` in place of an effect's name, you can set input scales and parameters of the car: `("inputs",
"full_brake")`, `("parameters", "cornering_stiffness_rear")`.

## Inputs

`longitudinal` may be `accel_cmd`, `throttle_cmd + brake_cmd`, `throttle_cmd + brake_pressure`, `throttle_cmd`,
`motor_current`, `speed_cmd` (with the effect `speed_controller`) or `v` (measured: then only lateral motion is
judged; the slope of `v` over 0.2 s, with what hills and drags take, shifts load between the axles, and is what steered
wheels pull or brake with; where effects say that the wheels show another speed than the car has, `v` is the shown one).
Input scales are in `[inputs]` and can be fitted. There, `full_pressure` [Pa] says which brake pressure is full brake
(5e6 where it is not stated, as of hydraulic brakes; air brakes have about 8e5), and `full_current` [A] which motor
current is full throttle (100). `steer_scale` and `steer_zero` say what a column of a log means. They change nothing
when a stack drives the model, because it commands the angle of the road wheels [rad]: there, `steer_ratio` and
`steer_offset` act.

"""

OWN = """
## Your own effect

Write one file. The decorator describes the effect, and the function is compiled on first use:

```python
from vehicle.model.effect import Key, effect

@effect(
    name="magnet", slot="force",
    physics="a magnet at the end of the road pulls the car", equation="a = c", source="my notebook",
    parameters=(Key("c", "m/s^2", low=0.1, high=1.0, neutral=0.0, least=0.05, meaning="pull"),),
    reveals="stand still with released brake",
)
def magnet(x, p, m):
    x.drag += p.c * x.mass
```

`dvp effects magnet --effects my_effect.py` shows it, and `dvp compare` also accepts `--effects`. A package announces
its effects under the entry point group `pytest_dvp.effects` (a module, or one effect). `x` is the bus (its fields are
listed below; `dvp effects --fields` prints them), `p` holds the parameters by key, and `m` is the memory of the effect,
declared as `memory=(Memory("name"),)`.

A `Key` has two ranges. `low` to `high` is the typical range: a search stays near it, and a model file may hold a value
outside it without a warning. `minimum` to `maximum` is the range that the equation allows (without them: any value). A
value outside it is refused, with its place in the file and the allowed range. The neutral value always passes.

The slots are computed in this order:

| slot | changes |
|---|---|
| command | `x.steer`, `x.accel` as wanted |
| actuator | `x.steer`, `x.accel` as produced, mean over the step (`x.steer_lead`, `x.accel_lead`: start minus mean) |
| road | `x.grade`, `x.bank` |
| force | `x.traction`, `x.brake`, `x.resistance` [N, >= 0], `x.drag` [N, signed] |
| body | `x.fy_front`, `x.fy_rear`, their tangents, `x.turning_inertia`, `x.yaw_moment` |
| sensor | `x.meas_...` |
| perception | object tracks: (tracks, p, rng), `vehicle/model/perception_effects.py`; [perception.md](perception.md) |

"""

FIELDS = """\
### Fields of the bus

All fields are doubles in SI units, with x forward, y left and yaw counter-clockwise. An effect may read all of them in
any slot (a field that a later slot sets holds the value of the last step) and may change those of its slot. Each step
computes: command, slots command, actuator, road and force, tyres, slot body, integration, slot sensor. A road of
a stated friction cuts traction and brake after the slot force, and the side forces of the axles after the effects of
the slot body up to order 60 (`tyre_saturation`); those of a higher order get what the road holds.
"""

PARAMETERS = """
## Parameters of the car

These keys may stand in `[parameters]`. Only `wheelbase` must; a data sheet gives some of the others.
"""

CATALOGUE = """
## Catalogue

Each key shows its typical range, and then the range that a model file may use.
"""


def _row(effect: Effect) -> str:
    keys = "<br>".join(f"`{k.name}` {k.low:g} to {k.high:g} {k.unit} ({k.allowed})" for k in effect.parameters)
    cells = (
        f"`{effect.name}`" + (" T" if effect.tyres else ""),
        effect.physics,
        f"{effect.equation}",
        keys,
        ", ".join(effect.ties),
        effect.reveals,
    )
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def _parameters() -> list[str]:
    rows = []
    for d in CAR_DECLARATIONS:
        meaning, _, default = d.meaning.partition("; default ")
        default = default or ("must be given" if d.default is None else f"{d.default:g} {d.unit}")
        rows.append(f"| `{d.name}` | {d.low:g} to {d.high:g} {d.unit} | {default} | {meaning} |")
    return rows


def _fields() -> list[str]:
    out = []
    for title, fields in bus_table().items():
        out += [f"{title[0].upper()}{title[1:]}:", "", "| field | unit | meaning |", "|---|---|---|"]
        out += [f"| `x.{f.name}` | {f.unit} | {f.meaning} |" for f in fields] + [""]
    return out


def page() -> str:
    """The whole page."""
    out = [HEAD + "| key | range | where nothing is declared | meaning |", "|---|---|---|---|"]
    out += [f"| `{k.name}` | {k.low:g} to {k.high:g} {k.unit} | {k.neutral:g} | {k.meaning} |" for k in INPUT_KEYS]
    out += [PARAMETERS, "| key | range | where it is not given | meaning |", "|---|---|---|---|", *_parameters()]
    out += [OWN + FIELDS, *_fields(), CATALOGUE]
    for slot in SLOTS:
        chosen = [e for e in catalogue().values() if e.slot == slot]
        out += [f"### {slot}", "", "| name | what happens | equation | keys | easily taken for | shows in |"]
        out += ["|---|---|---|---|---|---|", *(_row(e) for e in chosen), ""]
    out += ["Sources:", "", *(f"- `{e.name}`: {e.source}" for e in catalogue().values())]
    return "\n".join(out) + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
