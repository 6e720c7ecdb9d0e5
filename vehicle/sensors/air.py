"""How far LiDAR and camera see through fog and precipitation.

Both follow from one number, the extinction of the air [1/m]: the share of light that a metre takes away.

- Fog of visual range V: extinction = ln(20) / V. V is the meteorological optical range, over which 5 % of a light are
  left. Source: WMO-No. 8, Guide to Instruments and Methods of Observation, vol. I, ch. 9.
- Rain of intensity R [mm/h]: 1.076 R^0.67 dB/km. Source: T. H. Carbonneau, D. R. Wisely, Opportunities and challenges
  for optical wireless, Proc. SPIE 3532, 1998; Recommendation ITU-R P.1814 quotes it.
- Snow: (0.0001023 L + 3.7855466) R^0.72 dB/km at a wavelength of L [nm], here 905, for wet snow. Source: Recommendation
  ITU-R P.1817-1, table 2. Dry snow takes away more: (0.0000542 L + 5.4958776) R^1.38. The constants of rain and snow
  were compared with published programs that quote these sources; the recommendations themselves were not at hand.
- Camera: the contrast of an object falls with exp(-extinction d) (Koschmieder). Its detector needs 5 % of it, which
  makes the visual range its limit. Source: W. E. K. Middleton, Vision through the Atmosphere, 1952, ch. 4.
- LiDAR: the echo falls with exp(-2 extinction d) / d^2; the weakest that counts is the one from `reach` in clear air:
  R exp(extinction R) = reach. Source: R. H. Rasshofer et al., Influences of weather phenomena on automotive laser radar
  systems, Advances in Radio Science 9, 2011.

Not modelled: echoes of drops and flakes, wet lenses, targets of low reflectance. Light: `vehicle.sensors.light`.
"""

from __future__ import annotations

import math
from typing import Final

LEFT: Final = 0.05  # of a light, over the visual range; of a contrast, for a detector
NEPER: Final = math.log(10.0) / 10.0 / 1000.0  # 1/m, of 1 dB/km
RAIN: Final = (1.076, 0.67)  # dB/km at 1 mm/h, exponent
SNOW: Final = (0.0001023 * 905.0 + 3.7855466, 0.72)
_ITERATIONS: Final = 60  # halvings: of 1 km to less than a rounding


def extinction_of_fog(visual_range: float) -> float:
    """Extinction [1/m] of fog with a visual range [m]; of a range of 0 that of 1 m."""
    return -math.log(LEFT) / max(visual_range, 1.0)


def extinction_of_precipitation(kind: str, intensity: float) -> float:
    """Extinction [1/m] of `rain` or `snow` of an intensity [mm/h]; 0 for any other kind."""
    factor, exponent = {"rain": RAIN, "snow": SNOW}.get(kind, (0.0, 1.0))
    return NEPER * factor * intensity**exponent if intensity > 0.0 else 0.0


def camera_range(reach: float, extinction: float) -> float:
    """How far [m] a camera's detector sees that reaches `reach` [m] in clear air."""
    return reach if extinction <= 0.0 else min(reach, -math.log(LEFT) / extinction)


def lidar_range(reach: float, extinction: float) -> float:
    """How far [m] a LiDAR sees that reaches `reach` [m] in clear air."""
    if extinction <= 0.0:
        return reach
    low, high = 0.0, reach
    for _ in range(_ITERATIONS):
        middle = 0.5 * (low + high)
        if math.log(max(middle, 1e-300)) + extinction * middle < math.log(reach):
            low = middle
        else:
            high = middle
    return low
