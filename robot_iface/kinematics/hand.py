"""A hand's geometry: where its digits begin, how they point, how long their bones are.

Palm frame of a right hand: origin at the wrist, x out of the palm (palmar), y towards the thumb (radial),
z along the middle metacarpal (distal). A left hand is the mirror image, y reversed: its palm frame is still
right-handed, with y ulnar, and joint angles keep their meaning on both sides.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robot_iface.errors import Refused
from robot_iface.types import Float64, PatientTwin, Side

# Bone lengths as parts of hand length, after Buchholz, Armstrong & Goldstein (1992),
# doi 10.1080/00140139208967812.
_PHALANX_PARTS = np.array(
    [
        [0.251, 0.196, 0.158],  # thumb: metacarpal, proximal, distal
        [0.245, 0.143, 0.097],
        [0.266, 0.170, 0.108],
        [0.244, 0.165, 0.107],
        [0.204, 0.117, 0.093],
    ]
)
_METACARPAL_PARTS = np.array([0.463, 0.446, 0.421, 0.414])
# Lateral offsets of the finger bases (thesis, DLR-HIT-Hand II), as parts of a 189 mm hand.
_LATERAL_PARTS = np.array([0.0300, 0.0060, -0.0150, -0.0350]) / 0.189
_THUMB_BASE_PARTS = np.array([0.016, 0.028, 0.018]) / 0.189
_THUMB_DISTAL = np.array([0.40, 0.66, 0.64])  # direction of the straight thumb
_THUMB_PALMAR = np.array([0.72, -0.66, 0.00])  # where its tip goes when it flexes, before orthogonalising
_PALM_PARTS = (
    np.array(
        [
            [0.0, 0.0, 0.0],  # wrist
            [0.0, -0.022, 0.022],  # cmc4: base of the ring and little metacarpals
            [0.0, 0.018, 0.062],  # palm_1, palm_2, palm_3: over the index, middle and little metacarpals
            [0.0, 0.0, 0.050],
            [0.0, -0.024, 0.058],
        ]
    )
    / 0.189
)


@dataclass(frozen=True, slots=True)
class HandGeometry:
    """Bone lengths and bases of one hand, stated for its right-hand form.

    Attributes:
        side: Side of the hand; ``left`` mirrors y on the way out of the kinematics.
        bases_m: First joint of each digit in the palm frame, shape (5, 3), order of DIGITS.
        base_rotation: Columns are the palmar, radial and distal axes of each straight digit, shape (5, 3, 3).
        bones_m: Length of the three bones beyond each base, shape (5, 3).
        palm_m: wrist, cmc4, palm_1..3 in the palm frame, shape (5, 3).
    """

    side: Side
    bases_m: Float64
    base_rotation: Float64
    bones_m: Float64
    palm_m: Float64

    def __post_init__(self) -> None:
        for name, shape in (
            ("bases_m", (5, 3)),
            ("base_rotation", (5, 3, 3)),
            ("bones_m", (5, 3)),
            ("palm_m", (5, 3)),
        ):
            value = np.ascontiguousarray(getattr(self, name), dtype=np.float64)
            if value.shape != shape or not bool(np.isfinite(value).all()):
                raise Refused(
                    f"hand geometry {name}",
                    f"of shape {value.shape}",
                    f"finite, {shape}",
                    "measure the hand again",
                )
            value.setflags(write=False)
            object.__setattr__(self, name, value)
        if not bool((self.bones_m > 0).all()):
            raise Refused("bone length", f"{self.bones_m.min():g} m", "above 0 m", "measure the hand again")

    @property
    def mirror(self) -> Float64:
        """Factors that turn right-hand coordinates into this side's, shape (3,)."""
        return np.array([1.0, -1.0 if self.side == "left" else 1.0, 1.0])

    @property
    def length_m(self) -> float:
        """Hand length: wrist to middle fingertip, straight."""
        return float(self.bases_m[2, 2] + self.bones_m[2].sum())


def average_hand(length_m: float = 0.189, side: Side = "right") -> HandGeometry:
    """The hand of average proportions.

    Args:
        length_m: Wrist crease to middle fingertip, m.
        side: Side of the hand.

    Raises:
        Refused: The length is not that of a human hand (0.10 to 0.26 m).
    """
    if not 0.10 <= length_m <= 0.26:
        raise Refused(
            "hand length", f"{length_m:g} m", "0.10 to 0.26 m", "measure wrist crease to middle fingertip"
        )
    bases = np.zeros((5, 3))
    bases[0] = _THUMB_BASE_PARTS
    bases[1:, 1] = _LATERAL_PARTS
    bases[1:, 2] = np.sqrt(_METACARPAL_PARTS**2 - _LATERAL_PARTS**2)
    # scaled so that wrist to middle fingertip is the hand length: the parts of the source sum to .990
    scale = length_m / float(bases[2, 2] + _PHALANX_PARTS[2].sum())
    rotation = np.broadcast_to(np.eye(3), (5, 3, 3)).copy()
    rotation[0] = _axes(_THUMB_DISTAL, _THUMB_PALMAR)
    return HandGeometry(side, bases * scale, rotation, _PHALANX_PARTS * scale, _PALM_PARTS * length_m)


def patient_hand(twin: PatientTwin) -> HandGeometry:
    """The hand that the patient's record states: its measured bones, else average ones for its length.

    Args:
        twin: The patient.

    Raises:
        Refused: The length or a bone is not that of a human hand.
    """
    hand = average_hand(twin.hand_length_m, twin.side)
    if not twin.bones_m:
        return hand
    bones = np.array(twin.bones_m, dtype=np.float64)
    return HandGeometry(hand.side, hand.bases_m, hand.base_rotation, bones, hand.palm_m)


def _axes(distal: Float64, palmar: Float64) -> Float64:
    """Right-handed axes whose z is ``distal`` and whose x lies as near ``palmar`` as it can."""
    z = distal / np.linalg.norm(distal)
    x = palmar - (palmar @ z) * z
    x = x / np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=1)
