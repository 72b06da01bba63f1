"""The association filter of Table 4.1: sample what each detection is, correct, weigh, resample."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rehab_app.tracking.rbmcda_particles import CLUTTER, Particles
from rehab_app.tracking.rbmcda_settings import RbmcdaSettings
from sessions.records.fields import Float64, Int64


@dataclass(frozen=True, slots=True)
class Association:
    """What one capture was taken for by the most probable particle.

    Attributes:
        detection: Row of the detection of each marker, CLUTTER where none, shape (N,).
        pixel_px: Filtered place of each marker, shape (N, 2).
        std_px: Its standard deviation, the larger axis, shape (N,).
    """

    detection: Int64
    pixel_px: Float64
    std_px: Float64


class RbmcdaFilter:
    """Follows N markers in the image through captures of unnamed detections.

    Args:
        settings: Noises, priors and readings.
        markers: How many markers there are.
        rng: Draws the associations.
    """

    def __init__(self, settings: RbmcdaSettings, markers: int, rng: np.random.Generator) -> None:
        self.particles = Particles(settings, markers)
        self._rng = rng

    def step(self, pixel_px: Float64, periods: float) -> Association:
        """Take the detections of one capture, one after another.

        Args:
            pixel_px: Their centres, shape (D, 2).
            periods: Time since the last capture in the settings' periods.
        """
        particles = self.particles
        particles.begin(periods)
        best = 0
        for detection, pixel in enumerate(pixel_px):
            tilde = particles.log_hypotheses(pixel)
            chosen, evidence = sampled(tilde, self._rng)
            particles.assimilate(detection, pixel, chosen)
            weight = particles.log_weight + evidence
            particles.log_weight = weight - np.logaddexp.reduce(weight)
            if effective(particles.log_weight) < particles.settings.resample_below * len(weight):
                particles.resample(self._rng)
        best = int(np.argmax(particles.log_weight))
        return described(particles, best)


def sampled(log_tilde: Float64, rng: np.random.Generator) -> tuple[Int64, Float64]:
    """Draw an association per particle from the optimal importance distribution (eqs. 4.30 to 4.33).

    Args:
        log_tilde: Unnormalised log probabilities, clutter first, shape (P, 1 + N).
        rng: Draws.

    Returns:
        Marker of each particle, CLUTTER for none, shape (P,), and the log of each sum, which is the factor on
        its weight, shape (P,).
    """
    top = log_tilde.max(axis=1, keepdims=True)
    cumulated = np.cumsum(np.exp(log_tilde - top), axis=1)
    total = cumulated[:, -1]
    drawn = (cumulated <= (rng.random(len(total)) * total)[:, None]).sum(axis=1)
    return drawn - 1, np.log(total) + top[:, 0]


def effective(log_weight: Float64) -> float:
    """Effective number of particles, 1 / sum of squared weights, of normalised log weights (P,)."""
    return float(np.exp(-np.logaddexp.reduce(2.0 * log_weight)))


def described(particles: Particles, best: int) -> Association:
    """One particle's account of a capture."""
    variance = particles.covariance[best, :, :2, :2]
    return Association(
        np.where(particles.active, particles.taken[best], CLUTTER),
        particles.mean[best, :, :2].copy(),
        np.sqrt(np.maximum(variance[:, 0, 0], variance[:, 1, 1])),
    )
