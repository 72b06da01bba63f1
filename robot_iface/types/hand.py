"""The vocabulary of the hand, as the motion core needs it without knowing recordings.

``sessions.records.names`` holds the same lists for files; a contract test keeps the two equal.
"""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

Float64: TypeAlias = NDArray[np.float64]
Int64: TypeAlias = NDArray[np.int64]
UInt8: TypeAlias = NDArray[np.uint8]
Side = Literal["left", "right"]

DIGITS: tuple[str, ...] = ("thumb", "index", "middle", "ring", "little")
FINGERS: tuple[str, ...] = DIGITS[1:]
JOINTS: tuple[str, ...] = (
    "thumb_cmc_flexion",
    "thumb_cmc_abduction",
    "thumb_mcp_flexion",
    "thumb_mcp_abduction",
    "thumb_ip",
    *(f"{finger}_{joint}" for finger in FINGERS for joint in ("mcp_flexion", "mcp_abduction", "pip", "dip")),
)
LANDMARKS: tuple[str, ...] = (
    *(f"thumb_{part}" for part in ("cmc", "mcp", "ip", "tip")),
    *(f"{finger}_{part}" for finger in FINGERS for part in ("mcp", "pip", "dip", "tip")),
    *("wrist", "cmc4", "palm_1", "palm_2", "palm_3"),
)


def joint_index(names: tuple[str, ...]) -> Int64:
    """Columns of the 21-joint order that the named joints occupy, shape (len(names),)."""
    return np.array([JOINTS.index(name) for name in names], dtype=np.int64)
