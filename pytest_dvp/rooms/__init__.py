"""Our packages under names that no other project has: `pytest_dvp.rooms.vehicle` is our `vehicle`, whatever hides that.

Begin with `side_by_side.py`, which says when the packages are loaded under these names, and how. A project with a
package `vehicle` of its own writes `from pytest_dvp.rooms.vehicle.messages import Command`.
"""

from __future__ import annotations

from pathlib import Path

# Python then finds the packages that lie beside pytest_dvp as submodules of this one.
__path__ = [*__path__, str(Path(__file__).resolve().parents[2])]
