"""The association filter against what it must equal: Kalman's, and the exact sum over all histories."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter

from rehab_app.tracking.rbmcda_filter import RbmcdaFilter
from rehab_app.tracking.rbmcda_particles import CLUTTER, Particles, image_model
from rehab_app.tracking.rbmcda_settings import DAMPED, LITERAL, RBMCDA, RbmcdaSettings
from sessions.records.fields import Float64, Int64

ONE = replace(RBMCDA, claims="one")
READINGS = {"rbmcda": RBMCDA, "literal": LITERAL, "one": ONE, "damped": DAMPED}


# --- the plain Kalman filter ---


def kalman(settings: RbmcdaSettings, start: Float64) -> KalmanFilter:
    """filterpy's filter of one marker that begins at a pixel."""
    model = image_model(settings, 1.0)
    n = len(model.transition)
    kf = KalmanFilter(dim_x=n, dim_z=2)
    kf.F, kf.Q, kf.H, kf.R = model.transition, model.process, model.measurement, model.noise
    kf.x = np.concatenate([start, np.zeros(n - 2)])
    variances = [settings.measurement_std_px**2] * 2 + [settings.velocity_std_px**2] * (n - 2)
    kf.P = np.diag(variances)
    return kf


def walk(rng: np.random.Generator, frames: int, start: Float64) -> Float64:
    return start + np.cumsum(rng.normal(0.0, 1.0, (frames, *start.shape)), axis=0)


@pytest.mark.parametrize("settings", READINGS.values(), ids=READINGS.keys())
def test_one_marker_and_no_clutter_is_the_plain_kalman_filter(settings: RbmcdaSettings) -> None:
    rng = np.random.default_rng(0)
    start = np.array([320.0, 240.0])
    sure = replace(settings, clutter_prior=1e-12)
    ours, plain = RbmcdaFilter(sure, 1, rng), kalman(sure, start)
    ours.particles.place(np.array([0]), start[None], sure.measurement_std_px)
    for pixel in walk(rng, 60, start):
        association = ours.step(pixel[None], 1.0)
        plain.predict()
        plain.update(pixel)
        assert association.detection.tolist() == [0]
        assert ours.particles.mean[:, 0] == pytest.approx(np.tile(plain.x, (100, 1)), abs=1e-9)
        assert ours.particles.covariance[:, 0] == pytest.approx(np.tile(plain.P, (100, 1, 1)), abs=1e-9)
        assert association.std_px[0] == pytest.approx(np.sqrt(plain.P[0, 0]))


@pytest.mark.parametrize("settings", READINGS.values(), ids=READINGS.keys())
def test_one_particle_whose_associations_are_forced_is_a_kalman_filter_per_marker(
    settings: RbmcdaSettings,
) -> None:
    rng = np.random.default_rng(1)
    starts = np.array([[100.0, 100.0], [104.0, 100.0], [102.0, 103.0]])
    single = replace(settings, particles=1)
    particles = Particles(single, 3)
    particles.place(np.arange(3), starts, single.measurement_std_px)
    plain = [kalman(single, start) for start in starts]
    for pixels in walk(rng, 40, starts):
        particles.begin(1.0)
        for marker in rng.permutation(3):
            particles.assimilate(int(marker), pixels[marker], np.array([marker]))
            plain[marker].predict()
            plain[marker].update(pixels[marker])
        for marker in range(3):
            assert particles.mean[0, marker] == pytest.approx(plain[marker].x, abs=1e-9)
            assert particles.covariance[0, marker] == pytest.approx(plain[marker].P, abs=1e-9)


# --- the exact filter, by enumeration ---


@dataclass(frozen=True)
class Exact:
    """Posterior over all association histories.

    Attributes:
        probability: Of each history, shape (K,).
        mean: Markers under each history, shape (K, N, 2).
        histories: Marker of every detection in order, CLUTTER for none, shape (K, D).
    """

    probability: Float64
    mean: Float64
    histories: Int64

    @property
    def expected(self) -> Float64:
        """Posterior mean of the markers, shape (N, 2)."""
        return np.einsum("k,knd->nd", self.probability, self.mean)


def normal(surprise: Float64, variance: float) -> float:
    """Density of an isotropic plane normal."""
    return float(np.exp(-0.5 * surprise @ surprise / variance) / (2.0 * np.pi * variance))


def enumerated(settings: RbmcdaSettings, starts: Float64, frames: list[Float64]) -> Exact:
    """Every history by itself, in scalars: marker by marker variances, no stacks, no logarithms."""
    markers = len(starts)
    count = sum(len(frame) for frame in frames)
    histories = np.array(list(product(range(CLUTTER, markers), repeat=count)), dtype=np.int64)
    mass, means = np.zeros(len(histories)), np.zeros((len(histories), markers, 2))
    for row, history in enumerate(histories):
        mass[row], means[row] = _one_history(settings, starts, frames, history)
    return Exact(mass / mass.sum(), means, histories)


def _one_history(
    settings: RbmcdaSettings, starts: Float64, frames: list[Float64], history: Int64
) -> tuple[float, Float64]:
    q, r = settings.process_std_px**2, settings.measurement_std_px**2
    width, height = settings.image_px
    mean, variance = starts.copy(), np.full(len(starts), r)
    mass, index = 1.0, 0
    for frame in frames:
        before = variance.copy()
        if settings.prediction == "every":
            variance = variance + q
        claimed: set[int] = set()
        for pixel in frame:
            marker, index = int(history[index]), index + 1
            if marker == CLUTTER:
                mass *= settings.clutter_prior / (width * height)
                continue
            if settings.claims == "one" and marker in claimed:
                return 0.0, mean
            claimed.add(marker)
            predicted = variance[marker] + (q if settings.prediction == "hypothesised" else 0.0)
            believed = before[marker] if settings.innovation == "posterior" else predicted
            mass *= (1.0 - settings.clutter_prior) / len(starts) * normal(pixel - mean[marker], believed + r)
            gain = predicted / (predicted + r)
            mean[marker] += gain * (pixel - mean[marker])
            variance[marker] = before[marker] = (1.0 - gain) * predicted
    return mass, mean


def tiny(seed: int, markers: int = 2, frames: int = 3, detections: int = 2) -> tuple[Float64, list[Float64]]:
    """Markers a few pixels apart and detections between them: every history has a say."""
    rng = np.random.default_rng(seed)
    starts = np.array([[100.0, 100.0], [103.0, 101.0], [101.0, 104.0]])[:markers]
    return starts, [starts.mean(axis=0) + rng.normal(0.0, 2.5, (detections, 2)) for _ in range(frames)]


def posterior(settings: RbmcdaSettings, starts: Float64, frames: list[Float64], seed: int) -> Particles:
    ours = RbmcdaFilter(settings, len(starts), np.random.default_rng(seed))
    ours.particles.place(np.arange(len(starts)), starts, settings.measurement_std_px)
    for frame in frames:
        ours.step(frame, 1.0)
    return ours.particles


def expected(particles: Particles) -> Float64:
    return np.einsum("p,pnd->nd", particles.weights, particles.mean[..., :2])


def standard_error(particles: Particles) -> Float64:
    """Of the weighted mean of independent particles, shape (N, 2)."""
    apart = particles.mean[..., :2] - expected(particles)
    return np.sqrt(np.einsum("p,pnd->nd", particles.weights**2, apart**2))


CLOSE_CALL = 0.3  # prior of clutter at which it is a rival of the markers in these tiny pictures
PICTURE = (60, 50)
EXACT = {
    name: replace(settings, clutter_prior=CLOSE_CALL, image_px=PICTURE, resample_below=0.0)
    for name, settings in {
        **{name: READINGS[name] for name in ("rbmcda", "literal", "one")},
        "every, posterior": replace(RBMCDA, innovation="posterior"),
        "hypothesised, predicted": replace(LITERAL, innovation="predicted"),
    }.items()
}


@pytest.mark.parametrize("settings", [EXACT["rbmcda"], EXACT["one"]], ids=["rbmcda", "one"])
def test_the_order_of_detections_does_not_matter_to_the_exact_posterior(settings: RbmcdaSettings) -> None:
    starts, frames = tiny(5, detections=3, frames=2)
    turned = [frame[::-1] for frame in frames]
    here, there = enumerated(settings, starts, frames), enumerated(settings, starts, turned)
    assert there.expected == pytest.approx(here.expected, abs=1e-12)
    same = [3 * frame + place for frame in range(2) for place in (2, 1, 0)]
    found = {tuple(history[same]): p for history, p in zip(there.histories, there.probability, strict=True)}
    for history, probability in zip(here.histories, here.probability, strict=True):
        assert found[tuple(history)] == pytest.approx(probability, abs=1e-12)


@pytest.mark.parametrize("settings", EXACT.values(), ids=EXACT.keys())
def test_particles_converge_to_the_exact_posterior(settings: RbmcdaSettings) -> None:
    starts, frames = tiny(7)
    exact = enumerated(settings, starts, frames).expected
    few = [posterior(replace(settings, particles=20), starts, frames, seed) for seed in range(20)]
    many = posterior(replace(settings, particles=20_000), starts, frames, 0)
    error = np.abs(expected(many) - exact)
    assert (standard_error(many) < 0.03).all()
    assert (error < 4.0 * standard_error(many)).all()
    assert error.max() < 0.2 * np.mean([np.abs(expected(one) - exact).max() for one in few])


@pytest.mark.parametrize("name", ["rbmcda", "one"])
def test_resampling_leaves_the_posterior_where_it_is(name: str) -> None:
    settings = replace(EXACT[name], particles=20_000, resample_below=1.0)
    starts, frames = tiny(7, markers=3)
    exact = enumerated(settings, starts, frames).expected
    assert expected(posterior(settings, starts, frames, 0)) == pytest.approx(exact, abs=0.04)


@pytest.mark.parametrize("name", ["rbmcda", "one"])
def test_permuted_detections_give_many_particles_the_same_posterior(name: str) -> None:
    settings = replace(EXACT[name], particles=20_000)
    starts, frames = tiny(7)
    here = posterior(settings, starts, frames, 0)
    there = posterior(settings, starts, [frame[::-1] for frame in frames], 1)
    error = np.hypot(standard_error(here), standard_error(there))
    assert (np.abs(expected(there) - expected(here)) < 4.0 * error).all()


def test_the_same_seed_gives_the_same_and_another_seed_another_history() -> None:
    starts, frames = tiny(9, markers=3, frames=6, detections=4)
    settings = replace(RBMCDA, clutter_prior=CLOSE_CALL, image_px=PICTURE)
    one, same, other = (posterior(settings, starts, frames, seed) for seed in (3, 3, 4))
    assert np.array_equal(one.mean, same.mean)
    assert np.array_equal(one.log_weight, same.log_weight)
    assert not np.array_equal(one.mean, other.mean)


@pytest.mark.parametrize("seed", range(4))
def test_the_account_of_a_capture_is_the_heaviest_particles(seed: int) -> None:
    starts, frames = tiny(seed, markers=3, detections=3)
    ours = RbmcdaFilter(EXACT["rbmcda"], 3, np.random.default_rng(seed))
    ours.particles.place(np.arange(3), starts, 0.7)
    for frame in frames:
        account = ours.step(frame, 1.0)
    best = int(np.argmax(ours.particles.weights))
    assert ours.particles.weights[best] > 2.0 / len(ours.particles.weights)
    assert np.array_equal(account.pixel_px, ours.particles.mean[best, :, :2])
    assert np.array_equal(account.detection, ours.particles.taken[best])
