"""What the association filter is told, and how each ambiguous line of its source is read.

Source: Cordella (2011), section 4.2.3 and Table 4.1, after Särkkä, Vehtari and Lampinen (2007),
doi 10.1016/j.inffus.2005.09.009.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from sessions.errors import Refused

Motion = Literal["static", "damped_velocity"]
Prediction = Literal["hypothesised", "every"]
Innovation = Literal["posterior", "predicted"]
Claims = Literal["many", "one"]


@dataclass(frozen=True, slots=True)
class RbmcdaSettings:
    """Settings of the Rao-Blackwellised Monte Carlo data association filter.

    Attributes:
        particles: Association histories that are followed at once.
        clutter_prior: Probability that a detection is no marker, p(a = 0); the rest is split equally.
        image_px: Width and height of the image: clutter is uniform on it, 1 / (width height), eq. 4.26.
        process_std_px: Standard deviation of a marker's displacement in one period, per axis (Q, eq. 4.4).
        measurement_std_px: Standard deviation of a detection's centre, per axis (R, eq. 4.5).
        velocity_std_px: With ``damped_velocity``: growth of the speed's deviation per period, px per period.
        damping: With ``damped_velocity``: share of the speed that is left after a period. Undamped, a marker
            that is not seen runs out of the picture.
        period_s: The time that the noises above are meant for; they grow with the time between captures.
        resample_below: Resample when the effective number of particles falls below this share of them.
        largest_std_px: An unseen marker's standard deviation grows no further than this.
        motion: ``static`` is eq. 4.3, a random walk. ``damped_velocity`` is ours.
        prediction: ``hypothesised`` reads eqs. 4.8 and 4.19 to the letter: only the marker that a detection
            is given to is predicted, once for each such detection; an unseen one never grows unsure.
            ``every`` predicts all markers once a capture, as a random walk means it.
        innovation: ``posterior`` reads eq. 4.25 to the letter: the likelihood's S has the covariance *before*
            the prediction. ``predicted`` puts the predicted one there, as eq. 4.22 integrates to. The
            correction itself always uses the predicted one: otherwise its gain could exceed 1.
        claims: ``many`` is Table 4.1: nothing keeps two detections of a capture from claiming one marker.
            ``one`` gives a marker one detection per capture and particle.

    Raises:
        Refused: A number lies outside what it means.
    """

    particles: int = 100
    clutter_prior: float = 0.02
    image_px: tuple[int, int] = (640, 480)
    process_std_px: float = 1.5
    measurement_std_px: float = 0.7
    velocity_std_px: float = 0.7
    damping: float = 0.85
    period_s: float = 1.0 / 30.0
    resample_below: float = 0.5
    largest_std_px: float = float("inf")
    motion: Motion = "static"
    prediction: Prediction = "every"
    innovation: Innovation = "predicted"
    claims: Claims = "many"

    def __post_init__(self) -> None:
        mend = "choose another number"
        if not 1 <= self.particles <= 100_000:
            raise Refused("particles", str(self.particles), "1 to 100000", mend)
        if not 0 < self.clutter_prior < 1:
            raise Refused("clutter prior", f"{self.clutter_prior:g}", "between 0 and 1", mend)
        lengths = (self.process_std_px, self.measurement_std_px, self.velocity_std_px, *self.image_px)
        for length_px in lengths:
            if not length_px > 0:
                raise Refused("settings of the filter", f"{length_px:g} px", "above 0 px", mend)
        if not (0 <= self.damping <= 1 and 0 <= self.resample_below <= 1 and self.period_s > 0):
            raise Refused("damping or resampling", "out of range", "a share from 0 to 1", mend)
        if not self.largest_std_px > self.process_std_px:
            raise Refused("largest deviation", f"{self.largest_std_px:g} px", "above the process noise", mend)


LITERAL = RbmcdaSettings(
    process_std_px=2.0,
    measurement_std_px=1.0,
    prediction="hypothesised",
    innovation="posterior",
    claims="many",
)
"""Every line of Table 4.1 and eqs. 4.2 to 4.33 to the letter, with the noises that suit that reading."""

RBMCDA = RbmcdaSettings(largest_std_px=4.0)
"""The product's mode: the thesis's filter with its predictions and eq. 4.25 repaired, nothing else changed.

Growth ends at 4 px: beyond that a marker that is not seen takes its neighbours' blobs.
"""

DAMPED = RbmcdaSettings(motion="damped_velocity", process_std_px=0.3)
"""The same with a speed for every marker, which is no longer the thesis's model (eq. 4.3)."""
