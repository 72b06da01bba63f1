from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from rehab_app.geometry.rotation import matrix_from_wxyz, rigid_fit, turn, wxyz_from_matrix


def test_matrices_agree_with_an_independent_library() -> None:
    turns = Rotation.random(200, random_state=1)
    wxyz = turns.as_quat(scalar_first=True)
    np.testing.assert_allclose(matrix_from_wxyz(wxyz), turns.as_matrix(), atol=1e-12)
    back = wxyz_from_matrix(turns.as_matrix())
    np.testing.assert_allclose(back * np.sign((back * wxyz).sum(1))[:, None], wxyz, atol=1e-9)
    assert (back[:, 0] >= 0).all()


def test_half_turns_keep_their_axis() -> None:
    for axis in np.eye(3):
        matrix = Rotation.from_rotvec(np.pi * axis).as_matrix()
        np.testing.assert_allclose(np.abs(wxyz_from_matrix(matrix)[1:]), axis, atol=1e-9)


def test_small_and_large_turns() -> None:
    vectors = np.random.default_rng(2).normal(size=(50, 3)) * np.logspace(-12, 0.3, 50)[:, None]
    np.testing.assert_allclose(turn(vectors), Rotation.from_rotvec(vectors).as_matrix(), atol=1e-12)


def test_rigid_fit_recovers_a_motion_and_ignores_weightless_points() -> None:
    rng = np.random.default_rng(3)
    p_b = rng.normal(size=(6, 3))
    rotation = Rotation.random(4, random_state=4).as_matrix()
    shift = rng.normal(size=(4, 3))
    p_a = np.einsum("nij,mj->nmi", rotation, p_b) + shift[:, None]
    p_a[:, 0] += 5.0
    weight = np.ones((4, 6))
    weight[:, 0] = 0.0
    fitted, moved = rigid_fit(p_a, p_b, weight)
    np.testing.assert_allclose(fitted, rotation, atol=1e-9)
    np.testing.assert_allclose(moved, shift, atol=1e-9)
    assert np.linalg.det(fitted).min() > 0
