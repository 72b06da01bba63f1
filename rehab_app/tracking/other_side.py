"""Whether named markers are those of the hand's mirror image: a hand of the other side than was stated."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rehab_app.hand.marker_model import MarkerModel
from rehab_app.hand.pose_prior import rest_prior
from rehab_app.hand.pose_problem import PoseProblem
from rehab_app.hand.pose_solver import solve_from_nothing
from rehab_app.hand.protocol import MarkerProtocol
from rehab_app.hand.subject import average_subject
from sessions.records import Side
from sessions.records.fields import Float64

_SIZE_STD = 0.15
_CAPTURES = 5
_EVERY = 6
_CLEARLY = 6.0  # by this much less the other side must cost, a likelihood ratio of some hundreds a capture
_FEWEST = 5


class SideCheck:
    """Looks at the first second of a tracked hand and says if it is rather one of the other side.

    It only says so: the side is stated by a person and never changed.

    Args:
        protocol: The markers.
        side: Side of the hand, as stated.
    """

    def __init__(self, protocol: MarkerProtocol, side: Side) -> None:
        self._protocol = protocol
        self._side: Side = side
        self._taken: list[Float64] = []
        self._fed = 0
        self._complaint: str | None = None

    @property
    def complaint(self) -> str | None:
        """That the hand seems to be of the other side, one sentence; None if it does not."""
        return self._complaint

    def feed(self, p_camera_m: Float64) -> None:
        """Take the named markers (M, 3) of a capture, NaN where unseen; the first full ones are looked at."""
        if len(self._taken) == _CAPTURES:
            return
        self._fed += 1
        if (self._fed - 1) % _EVERY or int(np.isfinite(p_camera_m).all(axis=1).sum()) < _FEWEST:
            return
        self._taken.append(p_camera_m)
        if len(self._taken) == _CAPTURES:
            self._judge(np.array(self._taken))

    def _judge(self, p_camera_m: Float64) -> None:
        other: Side = "left" if self._side == "right" else "right"
        gain = fit_costs(p_camera_m, self._protocol, self._side) - fit_costs(
            p_camera_m, self._protocol, other
        )
        if float(np.median(gain)) > _CLEARLY:
            self._complaint = (
                f"The markers fit a {other} hand better than the {self._side} hand that was stated: "
                f"state the {other} side if that is the hand in view, else check the markers' names."
            )


def fit_costs(p_camera_m: Float64, protocol: MarkerProtocol, side: Side) -> Float64:
    """How badly an average hand of one side fits named markers in each of some captures, shape (N,).

    The hand's size is free. A cost is half the robust sum of squares, in standard deviations, of what the
    markers lie off, with what the joints lie beyond their limits and away from rest: the mirror image of a
    bent finger is one bent backwards.

    Args:
        p_camera_m: Markers, NaN where unseen, shape (N, M, 3).
        protocol: The markers.
        side: Side of the hand.
    """
    worn = replace(protocol, size_std=max(protocol.size_std, _SIZE_STD))
    sigma_m = np.sqrt(protocol.noise_m**2 + (protocol.offset_stds_m**2).mean(axis=1))
    precision = np.where(np.isfinite(p_camera_m), 1.0 / sigma_m[:, None] ** 2, 0.0)
    model = MarkerModel(average_subject(protocol, side), worn)
    problem = PoseProblem(model, np.nan_to_num(p_camera_m), precision, rest_prior(len(p_camera_m)))
    return problem.cost(solve_from_nothing(problem))
