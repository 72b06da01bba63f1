"""Rotations for many frames at once: quaternions wxyz, matrices, small turns, and the best rigid fit."""

from __future__ import annotations

import numpy as np

from sessions.records.fields import Float64


def matrix_from_wxyz(q_wxyz: Float64) -> Float64:
    """Rotation matrices (..., 3, 3) of unit quaternions (..., 4)."""
    w, x, y, z = np.moveaxis(np.asarray(q_wxyz, dtype=np.float64), -1, 0)
    rows = [
        *(1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        *(2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        *(2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    ]
    return np.stack(rows, axis=-1).reshape(*w.shape, 3, 3)


def wxyz_from_matrix(rotation: Float64) -> Float64:
    """Unit quaternions (..., 4), first component not negative, of rotation matrices (..., 3, 3)."""
    m = rotation
    diagonal = m[..., [0, 1, 2], [0, 1, 2]]
    trace = diagonal.sum(axis=-1)
    squares = np.concatenate([(1 + trace)[..., None], 1 - trace[..., None] + 2 * diagonal], axis=-1)
    pairs = _products(m)
    row = np.argmax(squares, axis=-1)
    table = np.empty((*row.shape, 4, 4))
    upper = {(0, 1): 0, (0, 2): 1, (0, 3): 2, (1, 2): 3, (1, 3): 4, (2, 3): 5}
    for a in range(4):
        table[..., a, a] = squares[..., a]
        for b in range(a + 1, 4):
            table[..., a, b] = table[..., b, a] = pairs[..., upper[a, b]]
    q = np.take_along_axis(table, row[..., None, None], axis=-2)[..., 0, :]
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    return np.where(q[..., :1] < 0, -q, q)


def turn(rotation_vector_rad: Float64) -> Float64:
    """Rotation matrices (..., 3, 3) of rotation vectors (..., 3): axis times angle."""
    angle = np.linalg.norm(rotation_vector_rad, axis=-1, keepdims=True)
    # sin(a/2)/a without dividing by zero: numpy's sinc is sin(pi x)/(pi x)
    half = 0.5 * np.sinc(angle / (2.0 * np.pi))
    return matrix_from_wxyz(np.concatenate([np.cos(angle / 2.0), half * rotation_vector_rad], axis=-1))


def rigid_fit(p_a_m: Float64, p_b_m: Float64, weight: Float64) -> tuple[Float64, Float64]:
    """The rotation and shift that carry points of b nearest to those of a, weighted (Kabsch).

    Args:
        p_a_m: Points in a, shape (N, M, 3); those of weight 0 may be anything finite.
        p_b_m: The same points in b, shape (N, M, 3) or (M, 3).
        weight: Weight of each point, shape (N, M).

    Returns:
        ``R_a_b`` (N, 3, 3) and ``p_a_b_m`` (N, 3), the origin of b in a.
    """
    share = weight / np.maximum(weight.sum(axis=1, keepdims=True), 1e-12)
    b = np.broadcast_to(p_b_m, p_a_m.shape)
    mean_a = np.einsum("nm,nmi->ni", share, p_a_m)
    mean_b = np.einsum("nm,nmi->ni", share, b)
    cross = np.einsum("nm,nmi,nmj->nij", share, p_a_m - mean_a[:, None], b - mean_b[:, None])
    u, _, vt = np.linalg.svd(cross)
    flip = np.ones((len(cross), 3))
    flip[:, 2] = np.sign(np.linalg.det(u @ vt))
    rotation = (u * flip[:, None, :]) @ vt
    return rotation, mean_a - np.einsum("nij,nj->ni", rotation, mean_b)


def _products(m: Float64) -> Float64:
    """4 times the products wx, wy, wz, xy, xz, yz of a rotation's quaternion, shape (..., 6)."""
    pairs = [
        *(m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]),
        *(m[..., 0, 1] + m[..., 1, 0], m[..., 0, 2] + m[..., 2, 0], m[..., 1, 2] + m[..., 2, 1]),
    ]
    return np.stack(pairs, axis=-1)
