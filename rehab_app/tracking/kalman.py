"""The Kalman filter over stacks of states: every array may have any leading axes (particles, markers).

Notation of Kalman's textbook form: x' = F x + w, w ~ N(0, Q); y = H x + v, v ~ N(0, R).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sessions.records.fields import Float64


@dataclass(frozen=True, slots=True)
class LinearModel:
    """One linear Gaussian model for all states of a stack.

    Attributes:
        transition: F, shape (n, n).
        process: Q, shape (n, n).
        measurement: H, shape (m, n).
        noise: R, shape (m, m).
        still: Whether F is the identity, which saves its products.
    """

    transition: Float64
    process: Float64
    measurement: Float64
    noise: Float64
    still: bool = False


def predicted(mean: Float64, covariance: Float64, model: LinearModel) -> tuple[Float64, Float64]:
    """One step on.

    Args:
        mean: States, shape (..., n).
        covariance: Their covariances, shape (..., n, n).
        model: The model.

    Returns:
        Means and covariances after the step, same shapes.
    """
    f = model.transition
    if model.still:
        return mean, covariance + model.process
    return mean @ f.T, f @ covariance @ f.T + model.process


def innovation_covariance(covariance: Float64, model: LinearModel) -> Float64:
    """S = H P H' + R for covariances (..., n, n), shape (..., m, m)."""
    h = model.measurement
    return h @ covariance @ h.T + model.noise


def corrected(
    mean: Float64, covariance: Float64, measured: Float64, model: LinearModel
) -> tuple[Float64, Float64]:
    """States after a measurement each.

    Args:
        mean: Predicted states, shape (..., n).
        covariance: Their covariances, shape (..., n, n).
        measured: Measurements, shape (..., m), or one for all.
        model: The model.

    Returns:
        Means and covariances, same shapes as the states'; the covariances exactly symmetric.
    """
    h = model.measurement
    cross = covariance @ h.T
    gain = cross @ np.linalg.inv(innovation_covariance(covariance, model))
    surprise = measured - mean @ h.T
    after = covariance - gain @ np.swapaxes(cross, -1, -2)
    return (
        mean + np.einsum("...nm,...m->...n", gain, surprise),
        0.5 * (after + np.swapaxes(after, -1, -2)),
    )


def plane_terms(covariance: Float64) -> Float64:
    """What the log density of plane normals needs of their covariances (..., 2, 2), shape (..., 4).

    The three numbers of the inverse's quadratic form, halved, and the logarithm of the norm.
    """
    a, b, c = covariance[..., 0, 0], covariance[..., 0, 1], covariance[..., 1, 1]
    determinant = a * c - b * b
    norm = -0.5 * np.log(determinant) - np.log(2.0 * np.pi)
    return np.stack([0.5 * c / determinant, -b / determinant, 0.5 * a / determinant, norm], axis=-1)


def log_density(surprise: Float64, terms: Float64) -> Float64:
    """Log density of zero-mean plane normals at (..., 2), of their ``plane_terms`` (..., 4), shape (...)."""
    u, v = surprise[..., 0], surprise[..., 1]
    return terms[..., 3] - (terms[..., 0] * u + terms[..., 1] * v) * u - terms[..., 2] * v * v
