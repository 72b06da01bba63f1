"""The vocabulary of the hand: digits, joints, landmarks and frames, each in its one fixed order.

Arrays over digits, joints or landmarks use these orders everywhere, in memory and in files.
"""

from __future__ import annotations

from typing import Literal

Side = Literal["left", "right"]
SIDES: tuple[Side, ...] = ("left", "right")

DIGITS: tuple[str, ...] = ("thumb", "index", "middle", "ring", "little")
FINGERS: tuple[str, ...] = DIGITS[1:]

THUMB_JOINTS: tuple[str, ...] = (
    "thumb_cmc_flexion",
    "thumb_cmc_abduction",
    "thumb_mcp_flexion",
    "thumb_mcp_abduction",
    "thumb_ip",
)
JOINTS: tuple[str, ...] = THUMB_JOINTS + tuple(
    f"{finger}_{joint}" for finger in FINGERS for joint in ("mcp_flexion", "mcp_abduction", "pip", "dip")
)
"""The 21 joints: flexion closes the hand; abduction is positive towards the thumb's side (radial)."""

PALM_LANDMARKS: tuple[str, ...] = ("wrist", "cmc4", "palm_1", "palm_2", "palm_3")
LANDMARKS: tuple[str, ...] = (
    tuple(f"thumb_{part}" for part in ("cmc", "mcp", "ip", "tip"))
    + tuple(f"{finger}_{part}" for finger in FINGERS for part in ("mcp", "pip", "dip", "tip"))
    + PALM_LANDMARKS
)
"""The 25 landmarks; the four of a digit run from the palm to the tip."""

FINGERTIPS: tuple[str, ...] = tuple(f"{digit}_tip" for digit in DIGITS)
FRAMES: tuple[str, ...] = ("world", "camera", "board", "palm", "robot_base", *LANDMARKS)


def digit_of(joint: str) -> str:
    """The digit that a joint or landmark name belongs to, such as ``index`` of ``index_pip``."""
    return joint.split("_", 1)[0]
