"""What the words of a column's name allow it to be. The numbers decide; words only keep out what cannot be meant."""

from __future__ import annotations

import re
from typing import Literal

from pytest_dvp.logs.mapping import LATITUDE, LONGITUDE, QUATERNION
from pytest_dvp.logs.units import find_unit

Family = Literal["position", "angle", "rate", "speed", "accel", "steer", "pedal", "wheel", "other"]

_COMMAND = {
    "cmd", "command", "commanded", "commands", "request", "requested", "req", "setpoint", "demand", "demanded", "des",
    "desired", "target", "tgt", "ref", "reference", "goal", "control", "ctrl", "input", "wanted", "planned", "soll",
}  # fmt: skip
_OTHER = {
    "roll", "pitch", "slip", "sideslip", "beta", "temp", "temperature", "press", "torque", "current", "voltage", "fuel",
    "gear", "lap", "curvature", "kappa", "altitude", "height", "alt", "z", "vz", "vy", "wx", "wy", "az", "std", "sigma",
    "cov", "covariance", "error", "err", "index", "id", "seq", "count", "checksum", "status", "mode", "valid",
    "quality", "satellites", "sats", "hdop", "pdop", "battery", "soc", "rpm", "power", "time", "mag", "jerk",
}  # fmt: skip
_SIDEWAYS = {"y", "vy", "lateral", "lat", "quer", "seitlich"}
_FAMILIES: dict[str, set[Family]] = {}
for _family, _words in {
    "position": "x y px py pos position east north easting northing ost nord lat latitude lon lng long longitude utm "
    "loc enu xpos ypos posx posy",
    "angle": "yaw heading head psi theta phi hdg course cog track orientation azimuth bearing gierwinkel "
    "kurswinkel cap",
    "rate": "gyro gyr ang gyroz gz w wz omega yawrate psidot angular r dpsi yawr rate turn angvel avz gierrate "
    "giergeschwindigkeit drehrate lacet",
    "speed": "v vx vel velocity speed spd encoder enc u velo vlon vlong sog groundspeed kph kmh mph geschwindigkeit "
    "fahrgeschwindigkeit tempo geschw vitesse",
    "accel": "a ax ay acc accel acceleration along alat accx accy imu accelerometer xl gforce force glat glong "
    "beschleunigung laengsbeschleunigung querbeschleunigung laengsbeschl querbeschl beschl",
    "steer": "steer steering delta df d str swa hwa eps steerangle wheelangle steeringangle rwa sas kuersi lenkwinkel "
    "lenkradwinkel lenkung volant braquage",
    "pedal": "throttle gas brake pedal accelerator tps app brk bremse gaspedal",
    "wheel": "wheel ws fl fr rl rr whl",
}.items():
    for _word in _words.split():
        _FAMILIES.setdefault(_word, set()).add(_family)  # type: ignore[arg-type]
_BY_UNIT: dict[str, set[Family]] = {
    "m": {"position"}, "rad": {"angle", "steer"}, "rad/s": {"rate", "wheel"}, "m/s": {"speed", "wheel"},
    "m/s^2": {"accel"}, "-": {"pedal", "steer"}, "Pa": {"pedal"},
}  # fmt: skip


def words_of(name: str) -> list[str]:
    """The words of a name in small letters, camel case and digits taken apart."""
    spaced = re.sub(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Za-z])(?=\d)|(?<=[A-Z])(?=[A-Z][a-z])", " ", name)
    return [word.lower() for word in re.split(r"[\W_]+", spaced) if word]


def is_command(name: str) -> bool:
    """Whether a word says that it is wanted, not measured."""
    return bool(_COMMAND & set(words_of(name)))


def families(name: str, unit: str = "") -> set[Family]:
    """What a column may be by its name and stated unit; empty: they tell nothing, so it may be anything."""
    if unit in (QUATERNION, LATITUDE, LONGITUDE):
        return {"angle"} if unit == QUATERNION else {"position"}
    words = words_of(name)
    said = set(words)
    found: set[Family] = set().union(*(_FAMILIES.get(word, set()) for word in words)) if words else set()
    if said & _OTHER and not said & {"angular", "ang", "yaw", "steer", "steering", "brake", "throttle", "speed"}:
        found = {"other"}
    if "steer" in found and said & {"steer", "steering", "swa", "str", "delta"}:
        found = {"other"} if said & {"rate", "speed", "vel", "velocity", "torque", "dot", "current"} else {"steer"}
    elif said & {"throttle", "gas", "brake", "pedal", "accelerator", "tps", "brk"}:
        found = {"other"} if said & {"pressed", "switch", "light", "active"} else {"pedal"}
    elif said & {"yaw", "psi", "heading", "theta"} and said & {"rate", "dot", "vel", "velocity", "speed", "gyro", "d"}:
        found = {"rate"}
    elif "twist" in said and not said & {"y"}:
        found = {"other"} if "angular" in said and "z" not in said else {"rate"} if "angular" in said else {"speed"}
    elif said & {"gyro", "gyr", "angular", "ang", "omega"}:
        found = {"rate"} if not said & {"x", "y", "roll", "pitch"} else {"other"}
    elif "angle" in said and said & {"wheel", "eps", "road", "front"}:
        found = {"steer"}
    elif "wheel" in found:
        found = {"wheel"} if said & {"fl", "fr", "rl", "rr", "left", "right"} else {"speed"}
    elif said & {"acc", "accel", "acceleration", "ax", "ay", "accelerometer", "xl"}:
        found = {"accel"}
    elif said & {"v", "vx", "vel", "velocity", "speed", "spd", "encoder"}:
        found = {"other"} if said & _SIDEWAYS else {"speed"}
    elif "speed" in found and said & _SIDEWAYS:
        found = {"other"}
    elif said & {"yaw", "heading", "psi", "hdg"}:
        found = {"angle"}
    elif len(found) > 1:  # `vicon x`, `imu x`: the more particular word is not known; numbers decide among them
        found -= {"accel"} if said & {"position", "pos"} else set()
    known = find_unit(unit) if unit else None
    if known is not None and known.si == "rad" and said & {"lat", "lon", "latitude", "longitude", "lng"}:
        return {"position"}
    if known is None:
        return found
    allowed = _BY_UNIT.get(known.si, {"other"})
    both = found & allowed
    return both or (set(allowed) if found != {"other"} else {"other"})
