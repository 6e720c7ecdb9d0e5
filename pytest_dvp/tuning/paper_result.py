"""The paper's result: metrics of its 10th iteration on DT, PE and RW.

Source: Arango et al., Sensors 2026, 26, 1338. MNCC of a stage, and metrics in the units of ours.
"""

from __future__ import annotations

TENTH: dict[str, tuple[float, float, float]] = {
    "ego x": (0.9970, 0.9972, 0.9998),
    "ego y": (0.9991, 0.9994, 0.9998),
    "steer": (0.9834, 0.8915, 0.9604),
    "velocity": (0.9568, 0.9655, 0.9893),
    "object x": (0.9847, 0.9962, 0.9940),
    "object y": (0.9671, 0.9591, 0.9808),
    "max TTC^-1": (0.378, 0.385, 0.415),  # 1/s
    "TET": (0.0, 0.0, 0.0),  # s
    "max jerk": (2.74, 2.46, 1.87),  # m/s^3
    "max yaw rate": (1.60, 1.61, 1.56),  # rad/s
    "completion time": (107.0, 108.0, 108.9),  # s
    "lateral RMSE, lane": (0.579, 0.679, 0.708),  # m
}
