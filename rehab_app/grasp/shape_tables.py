"""Tables 3.4 to 3.6 of the thesis: what ten and seven people's hands looked like around a cylinder."""

from __future__ import annotations

import numpy as np

from rehab_app.grasp.shape_spread import Spread, spread

_TRANSVERSE, _DIAGONAL = "transverse", "diagonal"

GLOVE_APERTURE_DEG: tuple[float, ...] = (
    *(48.93, 46.56, 48.90, 47.07, 47.42),
    *(52.36, 51.14, 48.29, 46.58, 48.75),
)
"""Table 3.4, transverse grip by glove: mean aperture of each of ten people, degrees."""
APERTURE_DEG: dict[str, tuple[float, ...]] = {
    _DIAGONAL: (49.54, 48.68, 50.39, 56.83, 56.77, 51.56, 53.57),
    _TRANSVERSE: (51.60, 58.27, 53.13, 52.39, 58.67, 59.06, 59.43),
}
"""Table 3.6 by grip: mean aperture of each of seven people, degrees."""
INDEX_RADIUS_MM: dict[tuple[str, str], tuple[float, ...]] = {
    ("pip", _DIAGONAL): (28.96, 22.81, 45.32, 33.54, 29.10, 29.80, 31.98),
    ("pip", _TRANSVERSE): (32.31, 26.02, 31.99, 28.17, 26.49, 28.36, 29.01),
    ("dip", _DIAGONAL): (32.83, 50.97, 26.36, 27.19, 36.35, 44.06, 30.95),
    ("dip", _TRANSVERSE): (29.76, 40.84, 28.32, 34.19, 33.03, 38.68, 27.41),
}
"""Table 3.5 by joint and grip: mean radius of the index finger of each of seven people, mm. Its rows for MCP
and TIP (1e16 mm and more) are round-off of a curvature of 0 and are left out."""


def table_spread(rows: tuple[float, ...]) -> Spread:
    """Mean and standard deviation over people, in the unit of the rows."""
    return spread(np.array(rows, dtype=np.float64))
