"""Writes docs/effects.md from the catalogue:  python -m scripts.make_effects_page

The page is text around a table; the table is the catalogue. A test says so when the page is behind.
"""

from __future__ import annotations

from pathlib import Path

from vehicle.model.bus import bus_table
from vehicle.model.command_inputs import INPUT_KEYS
from vehicle.model.effect import SLOTS, Effect
from vehicle.model.effect_catalogue import catalogue

PAGE = Path(__file__).resolve().parents[1] / "docs" / "effects.md"

HEAD = """\
# Effects

A vehicle model is a base (`kinematic_bicycle`, `dynamic_bicycle`) and effects that act on it, one compiled step for
all: commands -> actuators -> forces -> body -> road -> sensors. An effect at its neutral value is not there at all.
`dvp effects` lists them, `dvp effects NAME` says all about one, `--json` for programs. This page is made by
`python -m scripts.make_effects_page`.

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

Tyre effects (marked T) need tyres: with one of them a kinematic car moves as a single-track car whose axles are stiff
(cornering stiffness 48/rad of their load) unless `cornering_stiffness_front` and `_rear` are given. They steer
neutrally, so `understeer` with K gives r = v d/(L + K v^2). Below 1 m/s every car is kinematic.

## What a replay takes for granted

- A command logged at t holds from t to the next stamp; stamps need not be even. A measured input (`steer`, `v`) runs
  straight from stamp to stamp.
- A row shows the motion at its stamp, with the command of that stamp already acting: the ideal car has
  `yaw_rate = v tan(steer_cmd)/wheelbase` and `ax = accel_cmd` in the same row.
- Before the log begins its first command has been held for long: actuators are at rest there.
- Where a segment starts anew, pose and speed are set; delay lines, lags, limits and play run on; a sensor that shows
  the past sees a past moved along with the car.
- The ground is the plane of `road_grade` and `road_bank`: a replay knows no road, so a grade that changes along the way
  is not in it. (The twin in a scenario gets it from the elevation of the road file.)
- `ax`, `ay` are those at the rear axle; `ax_x`, `ay_x` in `[parameters]` name points ahead of it. Matters with tyres: a
  log whose `ay` is that of the centre of gravity shows the turn-in otherwise than the rear axle.

```python
from vehicle.model.model_file import read_model
from vehicle.model.open_loop import Replay

replay = Replay(read_model("model.toml"), t, {"steer_cmd": steer_cmd, "accel_cmd": accel_cmd})
rows = replay.run({("steer_delay", "T"): 0.21})  # (n, 8): x y yaw v yaw_rate ax ay steer
```

A run of 165 s at 50 Hz costs about 0.5 ms; another value costs no more than the run. The names `"inputs"` and
`"parameters"` in place of an effect's reach the input map and the car: `("inputs", "full_brake")`,
`("parameters", "cornering_stiffness_rear")`.

## Input maps

`longitudinal` may be `accel_cmd`, `throttle_cmd + brake_cmd`, `throttle_cmd + brake_pressure`, `throttle_cmd`,
`motor_current`, `speed_cmd` (with the effect `speed_controller`) or `v` (measured: then only lateral motion is judged).
Scales stand in `[inputs]` and can be fitted:

"""

OWN = """
## Your own effect

One file; the decorator describes it, the function is compiled on first use:

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

`dvp effects magnet --effects my_effect.py` shows it, `dvp compare` takes `--effects` too. A package announces its
effects under the entry point group `pytest_dvp.effects` (a module, or one effect). `x` is the bus (its fields are
listed below; `dvp effects --fields` prints them), `p` the parameters by key, `m` the effect's own memory, declared as
`memory=(Memory("name"),)`.

A `Key` has two ranges. `low` to `high` is what is met in practice: a search looks there, and a model file may hold a
value outside it without a word. `minimum` to `maximum` is what the equation allows (where left out: anything): a value
outside is refused, with the place in the file and what is allowed. The neutral value always passes.

Slots run in this order:

| slot | changes |
|---|---|
| command | `x.steer`, `x.accel` as wanted |
| actuator | `x.steer`, `x.accel` as produced, mean over the step (`x.steer_lead`, `x.accel_lead`: start minus mean) |
| force | `x.traction`, `x.brake`, `x.resistance` [N, >= 0], `x.drag` [N, signed] |
| body | `x.fy_front`, `x.fy_rear`, their tangents, `x.turning_inertia`, `x.yaw_moment` |
| road | `x.grade`, `x.bank` |
| sensor | `x.meas_...` |
| perception | object tracks: a function of (tracks, p, rng), see `vehicle/model/perception_effects.py` |

"""

FIELDS = """\
### Fields of the bus

All are doubles in SI units; x forward, y left, yaw counter-clockwise. An effect may read all of them in any slot (what
a later slot sets is that of the last step) and change those of its own slot. Per step: wish, slots command and
actuator, forces, tyres, slot body, slot road, integration, slot sensor.
"""

CATALOGUE = """
## Catalogue

Keys show the range met in practice, then what is allowed in a model file.
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
    out += [OWN + FIELDS, *_fields(), CATALOGUE]
    for slot in SLOTS:
        chosen = [e for e in catalogue().values() if e.slot == slot]
        out += [f"### {slot}", "", "| name | what happens | equation | keys | easily taken for | shows in |"]
        out += ["|---|---|---|---|---|---|", *(_row(e) for e in chosen), ""]
    out += ["Sources:", "", *(f"- `{e.name}`: {e.source}" for e in catalogue().values())]
    return "\n".join(out) + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
