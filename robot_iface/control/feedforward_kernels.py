"""What the learnt feed-forward computes in every tick, compiled."""

from __future__ import annotations

from robot_iface.compiled import compiled
from robot_iface.types import Float64


@compiled
def look_up(
    learnt_nm: Float64, place: float, q_rad: Float64, ends_rad: Float64, near_rad: float, out: Float64
) -> None:
    """Torque between two bins, less where it pushes a joint to an end of its range that it is near.

    Args:
        learnt_nm: Torque of each bin, (bins, J).
        place: Where to look, in bins.
        q_rad: Measured angles, (J,).
        ends_rad: Ends of today's range, (2, J).
        near_rad: Distance of an end from which on the push falls.
        out: The torque, (J,).
    """
    low = min(int(place), learnt_nm.shape[0] - 2)
    part = min(place - low, 1.0)
    for joint in range(q_rad.size):
        tau = learnt_nm[low, joint] * (1.0 - part) + learnt_nm[low + 1, joint] * part
        room = ends_rad[1, joint] - q_rad[joint] if tau > 0.0 else q_rad[joint] - ends_rad[0, joint]
        out[joint] = tau * min(max(room / near_rad, 0.0), 1.0)


@compiled
def collect(errors_rad: Float64, counts: Float64, place: float, error_rad: Float64) -> None:
    """Add an error, (J,), to the bin at a place, in bins, of sums (bins, J) and counts (bins,)."""
    nearest = min(int(place + 0.5), counts.size - 1)
    counts[nearest] += 1.0
    for joint in range(error_rad.size):
        errors_rad[nearest, joint] += error_rad[joint]
