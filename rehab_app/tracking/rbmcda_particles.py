"""Particles of association histories, each with a Kalman filter per marker (eqs. 4.13 and 4.15)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rehab_app.tracking.kalman import (
    LinearModel,
    corrected,
    innovation_covariance,
    log_density,
    plane_terms,
    predicted,
)
from rehab_app.tracking.rbmcda_settings import RbmcdaSettings
from sessions.records.fields import Float64, Int64

CLUTTER = -1
"""Association of a detection that is no marker (a = 0 in the thesis)."""


def image_model(settings: RbmcdaSettings, periods: float) -> LinearModel:
    """Eq. 4.3 for one marker over a time, in periods; with the speed below the place if it has one."""
    noise = settings.measurement_std_px**2 * np.eye(2)
    walk = periods * settings.process_std_px**2
    if settings.motion == "static":
        return LinearModel(np.eye(2), walk * np.eye(2), np.eye(2), noise, still=True)
    left = settings.damping**periods
    # displacement that a fading speed leads to: the sum of its geometric series, of one period per period
    reach = periods if settings.damping == 1.0 else (1.0 - left) / (1.0 - settings.damping)
    transition: Float64 = np.kron(np.array([[1.0, reach], [0.0, left]]), np.eye(2)).astype(np.float64)
    noises = np.array([walk, walk, *2 * [periods * settings.velocity_std_px**2]])
    process: Float64 = np.diag(noises)
    return LinearModel(transition, process, np.eye(2, 4), noise)


class Particles:
    """P particles over N markers whose states have n numbers, (u, v) first.

    Attributes:
        settings: How they move and are read.
        mean: States, shape (P, N, n).
        covariance: Their covariances, shape (P, N, n, n).
        log_weight: Logarithms of the weights, normalised, shape (P,).
        taken: Detection that each marker was given in this capture, CLUTTER where none, shape (P, N).
        active: Markers that have been seen at all; the others are no hypothesis, shape (N,).
    """

    def __init__(self, settings: RbmcdaSettings, markers: int) -> None:
        n = 2 if settings.motion == "static" else 4
        self.settings = settings
        self.mean: Float64 = np.zeros((settings.particles, markers, n))
        self.covariance: Float64 = np.tile(np.eye(n), (settings.particles, markers, 1, 1))
        self.log_weight: Float64 = np.full(settings.particles, -np.log(settings.particles))
        self.taken: Int64 = np.full((settings.particles, markers), CLUTTER, dtype=np.int64)
        self.active: NDArray[np.bool_] = np.zeros(markers, dtype=np.bool_)
        self._model = image_model(settings, 1.0)
        self._expected: Float64 = self.mean[..., :2]
        self._terms: Float64 = plane_terms(self.covariance[..., :2, :2])

    @property
    def weights(self) -> Float64:
        """Weights, summing to 1, shape (P,)."""
        weight = np.exp(self.log_weight - self.log_weight.max())
        return weight / weight.sum()

    def place(self, markers: Int64, pixel_px: Float64, std_px: float) -> None:
        """Put markers (K,) at pixels (K, 2) in every particle, at rest, to within ``std_px`` per axis."""
        self.mean[:, markers] = 0.0
        self.mean[:, markers, :2] = pixel_px
        variance = np.full(self.mean.shape[2], self.settings.velocity_std_px**2)
        variance[:2] = std_px**2
        self.covariance[:, markers] = np.diag(variance)
        self.active[markers] = True

    def begin(self, periods: float) -> None:
        """A new capture, so many periods after the last."""
        self._model = image_model(self.settings, periods)
        self.taken[:] = CLUTTER
        before = self.covariance
        if self.settings.prediction == "every":
            self.mean, grown = predicted(self.mean, before, self._model)
            tight = grown[..., 0, 0] <= self.settings.largest_std_px**2
            self.covariance = np.where(tight[..., None, None], grown, before)
        self._expect(before)

    def log_hypotheses(self, pixel_px: Float64) -> Float64:
        """Eqs. 4.26 to 4.29: log of likelihood times prior, clutter first, shape (P, 1 + N)."""
        settings = self.settings
        prior = settings.clutter_prior
        result = np.empty((len(self.mean), 1 + self.mean.shape[1]))
        width, height = settings.image_px
        result[:, 0] = np.log(prior / (width * height))
        split = np.log((1.0 - prior) / max(int(self.active.sum()), 1))
        result[:, 1:] = log_density(pixel_px - self._expected, self._terms) + split
        result[:, 1:][:, ~self.active] = -np.inf
        if settings.claims == "one":
            result[:, 1:][self.taken != CLUTTER] = -np.inf
        return result

    def assimilate(self, detection: int, pixel_px: Float64, chosen: Int64) -> None:
        """Correct, in every particle, the marker that a detection is given to; CLUTTER corrects none.

        Args:
            detection: Row of the detection, to be remembered.
            pixel_px: Where it is, shape (2,).
            chosen: Marker in each particle, shape (P,).
        """
        rows = np.flatnonzero(chosen != CLUTTER)
        markers = chosen[rows]
        mean, covariance = self.mean[rows, markers], self.covariance[rows, markers]
        if self.settings.prediction == "hypothesised":
            mean, covariance = predicted(mean, covariance, self._model)
        mean, covariance = corrected(mean, covariance, pixel_px, self._model)
        self.mean[rows, markers], self.covariance[rows, markers] = mean, covariance
        self.taken[rows, markers] = detection
        self._expected[rows, markers], self._terms[rows, markers] = self._next(mean, covariance)

    def resample(self, rng: np.random.Generator) -> None:
        """Systematic resampling (Kitagawa 1996): each particle about as often as its weight says."""
        count = len(self.log_weight)
        comb = (np.arange(count) + rng.random()) / count
        rows = np.minimum(np.searchsorted(np.cumsum(self.weights), comb), count - 1)
        self.mean, self.covariance, self.taken = self.mean[rows], self.covariance[rows], self.taken[rows]
        self._expected, self._terms = self._expected[rows], self._terms[rows]
        self.log_weight = np.full(count, -np.log(count))

    def _expect(self, before: Float64) -> None:
        """What a detection of each marker would look like; ``before`` are covariances without the step."""
        mean, covariance = self.mean, self.covariance
        if self.settings.prediction == "hypothesised":
            mean, covariance = predicted(mean, covariance, self._model)
        believed = before if self.settings.innovation == "posterior" else covariance
        self._expected = mean[..., :2].copy()
        self._terms = plane_terms(innovation_covariance(believed, self._model))

    def _next(self, mean: Float64, covariance: Float64) -> tuple[Float64, Float64]:
        """The same of markers that were just corrected: another detection of this capture may claim them."""
        believed = covariance
        if self.settings.prediction == "hypothesised":
            mean, grown = predicted(mean, covariance, self._model)
            believed = covariance if self.settings.innovation == "posterior" else grown
        return mean[..., :2], plane_terms(innovation_covariance(believed, self._model))
