"""A hand that was found is followed from capture to capture, lost, and found again."""

from __future__ import annotations

import numpy as np

from rehab_app.geometry.detections import Detections
from rehab_app.hand.marker_model import MarkerModel
from rehab_app.hand.protocol import MarkerProtocol
from rehab_app.hand.subject import Subject
from rehab_app.tracking.depth_memory import DepthMemory
from rehab_app.tracking.description import Knowledge, described
from rehab_app.tracking.evidence import evidence
from rehab_app.tracking.following import Circumstances, Followed, follow, merit
from rehab_app.tracking.hand_filter import NO_PAIRS, placed, plain_pairs, updated
from rehab_app.tracking.hand_state import HandState, at_rest, predicted
from rehab_app.tracking.labelling import NONE
from rehab_app.tracking.learning import Learning
from rehab_app.tracking.noise import Noise
from rehab_app.tracking.recovery import astray, recovered
from rehab_app.tracking.regaining import FIRST_STD, regained, regained_by_the_palm
from rehab_app.tracking.sight import Sight, sight
from rehab_app.tracking.start import LabelledCapture
from rehab_app.tracking.tracked import TrackedHand
from rehab_app.tracking.visibility import facing_chance, shown_after, shown_chance
from sessions.records import Side
from sessions.records.fields import Float64, Int64

_PATIENCE_S = 0.35  # without enough markers, after which the hand counts as lost
_COAST_S = 0.12  # for which a hand without markers is still estimated
_DOUBT_S = 0.09  # of explaining too little, after which it is asked whether the hand is elsewhere
_BETTER = 40.0  # merit by which another explanation of a capture must be better
_LONG_S = 0.5  # a doubt that lasts is looked into now and then only
_SELDOM = 5
_DOUBTFUL = 0.7  # share of the markers facing the camera, below which a capture is doubtful
_LEFT_OVER = 4
_NEVER_S = 2.0
_LONG_MISSING_S = 0.15
_DOUBT_M_S = 0.05
_AWAY = 0.1
_BEHIND_RATE = 0.02
_MOST_DOUBT_M = 0.005
_USUAL_RANGE_M = 0.7


class Pursuit:
    """Follows one hand.

    Args:
        protocol: The markers.
        side: Side of the hand.
        subject: The person, if known already.
    """

    def __init__(self, protocol: MarkerProtocol, side: Side, subject: Subject | None) -> None:
        self._count = len(protocol.names)
        self._noise_m = protocol.noise_m
        self._learning = Learning(protocol, side, subject)
        self._noise = Noise(self._count, protocol.noise_m)
        self._depths = DepthMemory(self._count)
        self._hand: HandState | None = None
        self._good: tuple[Float64, Float64] = (np.eye(3), np.zeros(21))
        self._shown: Float64 = np.ones(self._count)
        self._ever: Float64 = np.zeros(self._count)
        self._unseen_s: Float64 = np.zeros(6)
        self._missing_s: Float64 = np.zeros(self._count)
        self._missed_s = 0.0
        self._doubt_s = 0.0
        self._tracked_s = 0.0
        self._from_behind = 0.0
        self._tries = 0
        self._turn = 0
        self._expected: Float64 | None = None

    @property
    def begun(self) -> bool:
        """Whether a hand was ever found."""
        return self._hand is not None

    @property
    def holding(self) -> bool:
        """Whether the hand is in view, or was a moment ago."""
        return self._hand is not None and self._missed_s <= _PATIENCE_S

    @property
    def subject(self) -> Subject | None:
        """The person, as far as learnt by now."""
        return None if self._hand is None else self._model.subject

    @property
    def expected_m(self) -> Float64 | None:
        """Where the markers are expected next, shape (M, 3); None when unknown."""
        return self._expected if self._missed_s == 0.0 else None

    @property
    def never_seen(self) -> Int64:
        """Markers that were not seen at all though the hand has been for a while."""
        if self._tracked_s < _NEVER_S:
            return np.empty(0, dtype=np.int64)
        return np.flatnonzero(self._ever == 0.0)

    @property
    def _model(self) -> MarkerModel:
        model = self._learning.model
        assert model is not None
        return model

    def begin(self, capture: LabelledCapture) -> TrackedHand:
        """Begin with a capture whose markers have names.

        Raises:
            Refused: What was named is no human hand.
        """
        marker = np.flatnonzero(capture.row != NONE)
        pairs = plain_pairs(marker, capture.row[marker])
        view = sight(capture.detections)
        seen = evidence(view, pairs, self._count, None, _USUAL_RANGE_M)
        pose = self._learning.first(seen)
        t_ns = capture.detections.t_capture_ns
        begun = at_rest(t_ns, pose.rotation[0], pose.p_m[0], pose.joints_rad[0], np.diag(FIRST_STD**2))
        found = updated(self._model, begun, view, pairs, self._noise.wobble_m2, 0.0)
        real = pairs.row < capture.seen
        pairs = plain_pairs(marker[real], pairs.row[real])
        return self._taken(Followed(found.state, pairs, found.placed), view, 0.0)

    def take(self, detections: Detections) -> TrackedHand | None:
        """Take one capture; None where nothing is known of the hand any more."""
        assert self._hand is not None
        span_s = max(1e-9 * (detections.t_capture_ns - self._hand.t_ns), 0.0)
        view = sight(detections, across_scale=self._noise.across_scale)
        prior = predicted(self._hand, detections.t_capture_ns)
        found = self._followed(prior, view, span_s) if self.holding else self._found_again(view)
        if found is not None:
            return self._taken(found, view, span_s)
        self._missed_s += span_s
        self._unseen_s += span_s
        self._hand = prior
        self._shown = shown_chance(self._shown, span_s)
        if self._missed_s > _COAST_S:
            return None
        coasting = Followed(prior, NO_PAIRS, placed(self._model, prior))
        return described(coasting, view, self._knowledge(np.zeros((21, 21))))

    def _followed(self, prior: HandState, view: Sight, span_s: float) -> Followed | None:
        """The hand near where it is expected, or elsewhere if that explains far more."""
        shown = shown_chance(self._shown, span_s)
        about = Circumstances(
            shown,
            self._noise.wobble_m2,
            span_s,
            self._doubt_m2(span_s),
            self._from_behind,
            self._depths.insisted,
        )
        found = follow(self._model, prior, view, about)
        if found is not None:
            found = self._without_strays(found, prior, view, about)
        doubtful = found is None or self._doubtful(found, view)
        self._doubt_s = self._doubt_s + span_s if doubtful else 0.0
        if found is not None and not doubtful:
            self._good = found.state.rotation, found.state.joints_rad
        if self._doubt_s < _DOUBT_S or (self._doubt_s > _LONG_S and self._tries % _SELDOM):
            self._tries += 1
            return found
        other = self._found_again(view)
        if other is None or found is None:
            return other or found
        wobble_m2 = self._noise_m**2
        gain = merit(other, view, wobble_m2) - merit(found, view, wobble_m2)
        if gain <= _BETTER:
            return found
        self._doubt_s = 0.0
        return other

    def _doubtful(self, found: Followed, view: Sight) -> bool:
        """Whether too few of the markers that face the camera were found while blobs are left over."""
        after, explained = found.after, len(np.unique(found.pairs.marker))
        facing = float(facing_chance(after.normals, after.p_m, np.zeros(3)).sum())
        left = len(view) - len(found.pairs)
        return explained < _DOUBTFUL * facing and left >= _LEFT_OVER

    def _without_strays(
        self, found: Followed, prior: HandState, view: Sight, about: Circumstances
    ) -> Followed:
        """The same with a digit put where its markers are, if it was astray; one a capture."""
        strays = astray(self._model, found, view, self._missing_s > _LONG_MISSING_S)
        if not strays:
            return found
        self._turn += 1
        stray = strays[self._turn % len(strays)]
        return recovered(self._model, found, prior, view, about, stray) or found

    def _found_again(self, view: Sight) -> Followed | None:
        """The hand as it was before, or its palm, or open any way round; by turns, for the sake of time."""
        assert self._hand is not None
        self._tries += 1
        rotation, joints = self._good
        wobble_m2 = self._noise_m**2
        found = None
        if self._tries % 3 == 0:
            found = regained(self._model, view, joints[None], None, wobble_m2)
        elif self._tries % 3 == 1:
            postures = np.concatenate([joints[None], self._learning.postures_rad])
            found = regained(self._model, view, postures, rotation, wobble_m2)
        found = found or regained_by_the_palm(self._model, view, joints, rotation, wobble_m2)
        if found is not None and not self.holding:
            self._shown = np.ones(self._count)
        return found

    def _taken(self, found: Followed, view: Sight, span_s: float) -> TrackedHand:
        """Keep what a capture told."""
        state, pairs, after = found.state, found.pairs, found.after
        if self._hand is None:
            self._good = state.rotation, state.joints_rad
        self._hand = state
        self._missed_s = 0.0
        self._tracked_s += span_s
        self._ever[pairs.marker] = 1.0
        self._missing_s += span_s
        self._missing_s[pairs.marker] = 0.0
        self._shown = shown_after(shown_chance(self._shown, span_s), pairs.marker)
        self._unseen_s += span_s
        self._unseen_s[np.unique(self._model.digit[pairs.marker])] = 0.0
        self._noise.feed(state, after, view, pairs)
        self._depths.feed(after, view, pairs)
        self._learn_from_behind(found, first=span_s == 0.0)
        seen = evidence(view, pairs, self._count, after.p_m, _USUAL_RANGE_M)
        tracked = described(found, view, self._knowledge(self._learning.floor_rad2(state, seen)))
        self._learning.feed(state, seen, span_s, self._noise.wobble_m2)
        self._expected = after.p_m
        return tracked

    def _learn_from_behind(self, found: Followed, *, first: bool) -> None:
        """Of the markers that face away, how many are seen all the same: balls are, paper is not."""
        after = found.after
        away = np.flatnonzero(facing_chance(after.normals, after.p_m, np.zeros(3)) < _AWAY)
        if len(away):
            share = float(np.isin(away, found.pairs.marker).mean())
            self._from_behind += (1.0 if first else _BEHIND_RATE) * (share - self._from_behind)

    def _doubt_m2(self, span_s: float) -> Float64:
        """Variance of a marker's place for not having been found of late: the hand may be learnt wrongly."""
        missing_s = np.where(self._missing_s > 0.0, self._missing_s + span_s, 0.0)
        return np.minimum(_DOUBT_M_S * missing_s, _MOST_DOUBT_M) ** 2

    def _knowledge(self, floor_rad2: Float64) -> Knowledge:
        return Knowledge(self._model, self._noise.wobble_m2, self._unseen_s, floor_rad2)
