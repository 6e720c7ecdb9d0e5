"""A twin that leaves the house: one Python file, or an FMU 2 for co-simulation, that needs neither us nor a checkout.

Both hold the model file and the sources of the kernel that we drive it with, so that their motion is ours.
"""

from __future__ import annotations

import base64
import hashlib
import io
import sys
import textwrap
import zipfile
from pathlib import Path

import machine_code
import vehicle
from vehicle.model.model_file import model_text
from vehicle.model.vehicle_model import VehicleModel

_STAMP = (2020, 1, 1, 0, 0, 0)  # of the files inside: the same model gives the same bytes
_WIDTH = 116  # characters of a line of the written module

_MODULE = '''\
"""{title}: a vehicle model as a Python module; needs numpy, numba and msgspec.

    twin = Twin(x=0.0, y=0.0, yaw=0.0, v=10.0)
    shown = twin.step(0.05, steer_cmd=0.02, accel_cmd=0.5)  # 0.05 s on: what the sensors show, by name

Commands: steer_cmd [rad], accel_cmd [m/s^2], throttle_cmd and brake_cmd [0..1], speed_cmd [m/s]. Position [m] is that
of the rear axle's middle, x forward at yaw 0, yaw [rad] counter-clockwise.
"""

import atexit
import base64
import hashlib
import importlib
import io
import math
import shutil
import sys
import tempfile
import zipfile

DIGEST = "{digest}"
MODEL = {model!r}
OUTPUTS = ("x", "y", "yaw", "v", "yaw_rate", "ax", "ay", "steer")
COMMANDS = ("steer_cmd", "accel_cmd", "throttle_cmd", "brake_cmd", "speed_cmd")
STEP = 0.001  # s
ROUNDING = 1e-4  # of a step, by which a sum of times may be beyond its end; chosen
_COLUMNS = (1, 2, 4, 5, 8, 9, 10, 11)
_SOURCES = """
{sources}
"""


def _unpacked():
    """Puts the sources where Python finds them, unless the very same ones are there."""
    if "vehicle" in sys.modules:
        if getattr(sys.modules["vehicle"], "_exported_digest", DIGEST) == DIGEST:
            return
        raise ImportError("another exported twin is loaded already: use a process of its own for each")
    folder = tempfile.mkdtemp(prefix="twin-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    with zipfile.ZipFile(io.BytesIO(base64.b64decode(_SOURCES))) as archive:
        archive.extractall(folder)
    sys.path.insert(0, folder)
    importlib.import_module("vehicle")._exported_digest = DIGEST


_unpacked()
_model = importlib.import_module("vehicle.model.model_file").parse_model(MODEL)
_Plant = importlib.import_module("vehicle.model.plant").Plant
_State = importlib.import_module("vehicle.messages").VehicleState


class Twin:
    """The car, from rest at the origin or where it is put."""

    def __init__(self, t=0.0, x=0.0, y=0.0, yaw=0.0, v=0.0):
        self._plant = _Plant(_model, dt=STEP)
        self._plant.reset(_State(t=t, x=x, y=y, yaw=yaw, v=v))
        self._asked = 0.0
        self._done = 0

    def step(self, dt, steer_cmd=0.0, accel_cmd=0.0, throttle_cmd=0.0, brake_cmd=0.0, speed_cmd=0.0):
        """Hold these commands for dt [s]; returns what is shown at the end of the step of 1 ms in which dt ends.

        So a command acts in what is shown however short dt is; what is ahead is taken off the next step.
        """
        self._plant.command(steer_cmd, accel_cmd, throttle_cmd, brake_cmd, speed_cmd)
        self._asked += dt
        steps = math.ceil(self._asked / STEP - ROUNDING) - self._done
        if steps > 0:
            self._plant.advance(steps)
            self._done += steps
        return self.shown()

    def shown(self):
        """What the car's sensors show now, by name: {{"x": ..., ...}} in SI units."""
        row = self._plant.shown_row()
        return {{name: float(row[k]) for name, k in zip(OUTPUTS, _COLUMNS)}}
'''

_SLAVE = '''

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real  # noqa: E402


TAKEN = {taken!r}  # commands that this car obeys: who drives it by a log needs a column for each


class {name}(Fmi2Slave):
    """The twin as a co-simulation FMU: commands in, motion out, its start in x0, y0, yaw0 and v0."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        for name in TAKEN:
            setattr(self, name, 0.0)
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        for name in ("x0", "y0", "yaw0", "v0"):
            setattr(self, name, 0.0)
            self.register_variable(
                Real(name, causality=Fmi2Causality.parameter, variability=Fmi2Variability.fixed, start=0.0)
            )
        for name in OUTPUTS:
            setattr(self, name, 0.0)
            self.register_variable(Real(name, causality=Fmi2Causality.output))
        self._twin = None

    def exit_initialization_mode(self):
        self._twin = Twin(x=self.x0, y=self.y0, yaw=self.yaw0, v=self.v0)
        self._show(self._twin.shown())

    def do_step(self, current_time, step_size):
        self._show(self._twin.step(step_size, **dict((name, getattr(self, name)) for name in TAKEN)))
        return True

    def _show(self, values):
        for name, value in values.items():
            setattr(self, name, value)
'''


def python_text(model: VehicleModel, *, slave: str = "") -> str:
    """The Python module of a model; with `slave`, a class of that name for PythonFMU behind it.

    Raises ModelError for a model that is driven by a measured speed, which a command cannot stand for.
    """
    from vehicle.model.errors import ModelError

    if "v" in model.inputs.longitudinal or not model.inputs.steer.endswith("_cmd"):
        raise ModelError(
            "a model that is driven by what was measured has no commands of its own to be exported with",
            key="inputs", found=", ".join(model.inputs.columns), allowed="columns that end in _cmd",
        )  # fmt: skip
    archive = _sources()
    text = _MODULE.format(
        title=(model.name or model.base).replace("\\", " ").replace('"', "'"), model=model_text(model),
        digest=hashlib.sha256(archive).hexdigest(),
        sources="\n".join(textwrap.wrap(base64.b64encode(archive).decode(), _WIDTH)),
    )  # fmt: skip
    return text + (_SLAVE.format(name=slave, taken=_taken(model)) if slave else "")


def _taken(model: VehicleModel) -> tuple[str, ...]:
    """The commands of a step that a model obeys: pedals in place of the current and the pressure that its log holds."""
    stand_for = {"motor_current": ("throttle_cmd", "brake_cmd"), "brake_pressure": ("brake_cmd",)}
    return ("steer_cmd", *(name for one in model.inputs.longitudinal for name in stand_for.get(one, (one,))))


def write_fmu(model: VehicleModel, path: Path) -> None:
    """Write the FMU 2 of a model. Raises ModelError as `python_text`, ImportError without PythonFMU, RuntimeError if it
    cannot build.

    In a process of its own: an FMU of PythonFMU that has run in this one has brought a copy of that package, which
    cannot build another.
    """
    import subprocess
    import tempfile

    from reports.whole_file import write_whole

    with tempfile.TemporaryDirectory() as folder:
        text = python_text(model, slave="ExportedTwin").encode()
        # Python keeps modules by name: of two FMUs in one process, the second would drive the car of the first
        script = Path(folder) / f"twin_{hashlib.sha256(text).hexdigest()[:16]}.py"
        script.write_bytes(text)
        command = [sys.executable, "-m", "pythonfmu", "build", "-f", str(script), "-d", folder]
        ended = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if "No module named pythonfmu" in ended.stderr:
            raise ImportError("PythonFMU is not installed")
        if ended.returncode:
            raise RuntimeError(f"PythonFMU could not build: {ended.stderr.strip()}")
        write_whole(path, (Path(folder) / "ExportedTwin.fmu").read_bytes())


def _sources() -> bytes:
    """A ZIP archive of the sources that a twin is driven with."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for package, parts in ((machine_code, ("",)), (vehicle, ("", "model"))):
            root = Path(next(iter(package.__path__)))
            found = {file for part in parts for file in (root / part).glob("**/*.py" if part else "*.py")}
            for file in sorted(found):
                name = f"{root.name}/{file.relative_to(root).as_posix()}"
                archive.writestr(zipfile.ZipInfo(name, _STAMP), file.read_bytes(), zipfile.ZIP_DEFLATED)
    return out.getvalue()
