"""Import paths of version 0.1 that docs gave to users work for one more version, with a DeprecationWarning.

`pytest_dvp/__init__.py` appends the finder to `sys.meta_path`: it is asked only where no module of that name is found.
Delete this file, its test and that line with version 0.3.
"""

from __future__ import annotations

import importlib
import sys
import warnings
from collections.abc import Sequence
from importlib.machinery import ModuleSpec
from types import CodeType, ModuleType
from typing import Any

NEW_PATHS: dict[str, tuple[str, ...]] = {
    "pytest_dvp.ads_node": ("pytest_dvp.drive.stack_server",),
    "pytest_dvp.fixtures": ("pytest_dvp.plugin.fixtures",),
    "pytest_dvp.log": ("pytest_dvp.logs.log", "pytest_dvp.logs.log_contents", "pytest_dvp.logs.log_error"),
    "pytest_dvp.logs.read": ("pytest_dvp.logs.read_log",),
    "pytest_dvp.reality_gap": ("pytest_dvp.gap",),
    "pytest_dvp.reality_gap.black_box": (
        "pytest_dvp.gap.compare.compared_model",
        "pytest_dvp.gap.compare.model_loader",
    ),
    "pytest_dvp.reality_gap.manoeuvres": ("pytest_dvp.gap.manoeuvres",),
    "pytest_dvp.reality_gap.manoeuvres.robot": ("pytest_dvp.gap.manoeuvres.steering_robot",),
    "pytest_dvp.reality_gap.segments": ("pytest_dvp.gap.compare.segments",),
    "pytest_dvp.run": ("pytest_dvp.drive.run", "pytest_dvp.drive.result"),
    "vehicle.model.catalogue": ("vehicle.model.effect_catalogue",),
    "vehicle.model.parameters": ("vehicle.model.simulator_parameters",),
    "vehicle.model.replay": ("vehicle.model.open_loop",),
}
"""Old path, and where its names are now."""


NEW_NAMES = {"Subject": "ComparedModel", "load_subject": "load_compared_model"}
"""Old name, and the new one."""


class OldModule(ModuleType):
    """A module under its old path: its names are looked up in the new ones."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        name = NEW_NAMES.get(name, name)
        for path in NEW_PATHS[self.__name__]:
            module = importlib.import_module(path)
            if hasattr(module, name):
                return getattr(module, name)
        raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        """`pytest_dvp.run` was a module and a function in one."""
        return getattr(self, self.__name__.rpartition(".")[2])(*arguments, **options)


class OldPaths:
    """Finds a module by its old path (the protocols of finder and loader of `importlib`)."""

    def find_spec(self, name: str, path: Sequence[str] | None, target: ModuleType | None = None) -> ModuleSpec | None:
        """A spec whose loader is this object for a path of 0.1.0 that has moved; None for any other name."""
        if name not in NEW_PATHS:
            return None
        return ModuleSpec(name, self, is_package=name.endswith((".reality_gap", ".manoeuvres")))  # type: ignore[arg-type]

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        """The module that stands at an old path."""
        return OldModule(spec.name)

    def exec_module(self, module: ModuleType) -> None:
        """Warn (DeprecationWarning) with the path that the module has now."""
        new = " or ".join(NEW_PATHS[module.__name__])
        warnings.warn(f"{module.__name__} is {new} now", DeprecationWarning, stacklevel=2)

    def get_code(self, name: str) -> CodeType:
        """What `python -m` runs."""
        return compile(f"import runpy\nrunpy.run_module({NEW_PATHS[name][0]!r}, run_name='__main__')\n", name, "exec")


def install() -> None:
    """Append the finder, once."""
    if not any(isinstance(finder, OldPaths) for finder in sys.meta_path):
        sys.meta_path.append(OldPaths())
