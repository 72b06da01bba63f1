"""The one place that makes a tracker of a name."""

from __future__ import annotations

from typing import Literal

from rehab_app.hand.protocol import MarkerProtocol
from rehab_app.hand.subject import Subject
from rehab_app.tracking.kinematic import KinematicTracker
from rehab_app.tracking.rbmcda import RbmcdaTracker
from rehab_app.tracking.rbmcda_settings import LITERAL
from rehab_app.tracking.tracked import Labels, Tracker
from sessions.errors import Refused
from sessions.records import Side

TrackerName = Literal["kinematic", "rbmcda", "rbmcda-literal"]
TRACKERS: tuple[TrackerName, ...] = ("kinematic", "rbmcda", "rbmcda-literal")
"""Names of the trackers; the first is the default, the last the thesis's word by word, for comparison."""


def make_tracker(
    name: str,
    protocol: MarkerProtocol,
    side: Side,
    *,
    subject: Subject | None = None,
    labels: Labels | None = None,
    seed: int = 0,
) -> Tracker:
    """A tracker of a hand that wears a protocol's markers.

    Args:
        name: One of TRACKERS.
        protocol: The markers.
        side: Side of the hand; never inferred.
        subject: The person, if known already; otherwise learnt from the first second.
        labels: Markers named by a person in the first capture; without them an open hand is waited for.
        seed: Of whatever a tracker draws.

    Raises:
        Refused: There is no such tracker.
    """
    if name == "kinematic":
        return KinematicTracker(protocol, side, subject, labels)
    if name == "rbmcda":
        return RbmcdaTracker(protocol, side, subject, labels, seed=seed)
    if name == "rbmcda-literal":
        return RbmcdaTracker(protocol, side, subject, labels, seed=seed, settings=LITERAL)
    raise Refused("tracker", repr(name), "one of " + ", ".join(TRACKERS), "choose one of them")
