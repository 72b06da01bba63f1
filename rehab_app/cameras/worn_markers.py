"""How a person wears the markers: each a little beside its place."""

from __future__ import annotations

import numpy as np

from rehab_app.hand.marker_model import MarkerModel
from rehab_app.hand.protocol import MarkerProtocol
from rehab_app.hand.subject import Subject
from robot_iface.kinematics import HandGeometry


def wear_markers(
    geometry: HandGeometry,
    protocol: MarkerProtocol,
    rng: np.random.Generator,
    *,
    placing_std_m: float = 0.001,
) -> MarkerModel:
    """A protocol's markers, stuck on by a human.

    Args:
        geometry: The hand.
        protocol: The markers and the bones that they ride on.
        rng: Draws how far each marker sits from its place along and across its bone.
        placing_std_m: Standard deviation of that, m; a third of it in height over the bone.
    """
    beside = rng.standard_normal((len(protocol.names), 3)) * placing_std_m * np.array([1.0 / 3.0, 1.0, 1.0])
    return MarkerModel(Subject(geometry, protocol.names, protocol.offsets_m + beside), protocol)
