"""Laws of the association filter: weights, owners, seeds, draws, growth, claims and settings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rehab_app.tracking.rbmcda_filter import RbmcdaFilter, effective, sampled
from rehab_app.tracking.rbmcda_particles import CLUTTER, Particles
from rehab_app.tracking.rbmcda_settings import DAMPED, LITERAL, RBMCDA
from sessions.errors import Refused

ONE = replace(RBMCDA, claims="one")
READINGS = {"rbmcda": RBMCDA, "literal": LITERAL, "one": ONE, "damped": DAMPED}


@given(seed=st.integers(0, 10_000), reading=st.sampled_from(sorted(READINGS)), detections=st.integers(0, 6))
def test_weights_sum_to_one_and_every_detection_has_one_owner(
    seed: int, reading: str, detections: int
) -> None:
    rng = np.random.default_rng(seed)
    settings = replace(READINGS[reading], particles=int(rng.integers(1, 30)))
    ours = RbmcdaFilter(settings, 3, rng)
    ours.particles.place(np.arange(3), rng.uniform(100.0, 110.0, (3, 2)), 1.0)
    for _ in range(3):
        association = ours.step(rng.uniform(95.0, 115.0, (detections, 2)), float(rng.uniform(0.1, 5.0)))
        weights = ours.particles.weights
        assert weights.sum() == pytest.approx(1.0, abs=1e-12)
        assert np.exp(ours.particles.log_weight).sum() == pytest.approx(1.0, abs=1e-9)
        assert 1.0 - 1e-9 <= effective(ours.particles.log_weight) <= settings.particles * (1.0 + 1e-9)
        given_rows = association.detection[association.detection != CLUTTER]
        assert len(np.unique(given_rows)) == len(given_rows)
        assert ((given_rows >= 0) & (given_rows < detections)).all()
        assert np.isfinite(ours.particles.mean).all()
        assert (np.linalg.eigvalsh(ours.particles.covariance) > 0).all()


def test_resampling_copies_particles_as_their_weights_say() -> None:
    particles = Particles(replace(RBMCDA, particles=1000), 1)
    particles.place(np.array([0]), np.array([[50.0, 50.0]]), 1.0)
    particles.begin(1.0)
    particles.mean[:, 0, 0] = np.arange(1000)
    weight = np.random.default_rng(0).exponential(size=1000)
    particles.log_weight = np.log(weight / weight.sum())
    before = particles.weights
    particles.resample(np.random.default_rng(1))
    copies = np.bincount(particles.mean[:, 0, 0].astype(np.int64), minlength=1000)
    assert (np.abs(copies - 1000 * before) < 1.0).all()
    assert particles.weights == pytest.approx(np.full(1000, 0.001))


def test_draws_follow_the_importance_distribution() -> None:
    share = np.array([0.1, 0.0, 0.6, 0.3])
    with np.errstate(divide="ignore"):
        tilde = np.tile(np.log(2.5e-300 * share), (40_000, 1))
    chosen, evidence = sampled(tilde, np.random.default_rng(0))
    seen = np.bincount(chosen + 1, minlength=4) / len(chosen)
    assert seen == pytest.approx(share, abs=0.01)
    assert seen[1] == 0.0  # what is impossible is never drawn
    assert evidence == pytest.approx(np.full(40_000, np.log(2.5e-300)))  # no underflow


def test_an_unseen_marker_grows_unsure_only_where_all_are_predicted() -> None:
    pixels = np.array([[100.0, 100.0], [300.0, 300.0]])
    spread: dict[str, float] = {}
    for name, reading in READINGS.items():
        settings = replace(reading, largest_std_px=float("inf"))
        ours = RbmcdaFilter(settings, 2, np.random.default_rng(0))
        ours.particles.place(np.arange(2), pixels, settings.measurement_std_px)
        for _ in range(20):
            association = ours.step(pixels[:1], 1.0)
        spread[name] = float(association.std_px[1])
    assert spread["literal"] == pytest.approx(LITERAL.measurement_std_px)
    growth = np.sqrt(RBMCDA.measurement_std_px**2 + 20 * RBMCDA.process_std_px**2)
    assert spread["rbmcda"] == pytest.approx(growth)


def test_growth_ends_at_the_largest_deviation() -> None:
    ours = RbmcdaFilter(replace(RBMCDA, largest_std_px=5.0), 1, np.random.default_rng(0))
    ours.particles.place(np.array([0]), np.array([[100.0, 100.0]]), 0.7)
    for _ in range(200):
        association = ours.step(np.empty((0, 2)), 1.0)
    assert 3.0 < association.std_px[0] <= 5.0


def test_one_claim_keeps_a_second_detection_from_a_marker() -> None:
    twins = np.array([[100.0, 100.0], [100.2, 100.0]])
    for settings, both in ((RBMCDA, True), (ONE, False)):
        particles = Particles(settings, 1)
        particles.place(np.array([0]), twins[:1], 0.7)
        particles.begin(1.0)
        particles.assimilate(0, twins[0], np.zeros(settings.particles, dtype=np.int64))
        assert bool(np.isfinite(particles.log_hypotheses(twins[1])[:, 1]).all()) == both


def test_a_marker_that_was_never_placed_is_no_hypothesis() -> None:
    ours = RbmcdaFilter(RBMCDA, 2, np.random.default_rng(0))
    ours.particles.place(np.array([1]), np.array([[100.0, 100.0]]), 0.7)
    association = ours.step(np.array([[100.0, 100.5], [0.0, 0.0]]), 1.0)
    assert association.detection.tolist() == [CLUTTER, 0]


@pytest.mark.parametrize(
    "wrong",
    [
        {"particles": 0},
        {"clutter_prior": 0.0},
        {"clutter_prior": 1.0},
        {"process_std_px": 0.0},
        {"measurement_std_px": float("nan")},
        {"image_px": (0, 480)},
        {"damping": 1.5},
        {"largest_std_px": 0.1},
    ],
)
def test_settings_that_mean_nothing_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(Refused):
        replace(RBMCDA, **wrong)
