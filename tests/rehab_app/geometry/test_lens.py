from __future__ import annotations

import numpy as np
import pytest

from rehab_app.geometry.lens import STRAIGHT, Lens
from rehab_app.geometry.pinhole import KINECT
from sessions.errors import Refused

GRID = np.stack(np.meshgrid(np.linspace(0, 639, 9), np.linspace(0, 479, 7)), axis=-1).reshape(-1, 2)


@pytest.mark.parametrize(
    "coefficients",
    [(-0.28, 0.09, 0.001, -0.001), (0.1, -0.05, 0.0, 0.001, 0.01), (0.2, 0.1, 0.0, 0.0, 0.0, 0.15, 0.1, 0.0)],
)
def test_distorting_undoes_undistorting(coefficients):
    lens = Lens(coefficients)
    assert np.abs(lens.distorted(lens.undistorted(GRID, KINECT), KINECT) - GRID).max() < 1e-4
    assert not lens.straight
    assert not lens.folds(KINECT)


def test_the_model_by_hand():
    lens, pixel = Lens((-0.2, 0.05, 0.002, -0.003, 0.01)), np.array([[500.0, 100.0]])
    x, y = (500.0 - 319.5) / 525.0, (100.0 - 239.5) / 525.0
    s = x * x + y * y
    radial = 1 - 0.2 * s + 0.05 * s**2 + 0.01 * s**3
    bent = [
        x * radial + 2 * 0.002 * x * y - 0.003 * (s + 2 * x * x),
        y * radial + 0.002 * (s + 2 * y * y) - 2 * 0.003 * x * y,
    ]
    expected = np.array(bent) * 525.0 + [319.5, 239.5]
    assert np.allclose(lens.distorted(pixel, KINECT)[0], expected)


def test_a_straight_lens_moves_nothing():
    for lens in (STRAIGHT, Lens((0.0, 0.0, 0.0, 0.0))):
        assert lens.straight
        assert (lens.undistorted(GRID, KINECT) == GRID).all()
        assert (lens.distorted(GRID, KINECT) == GRID).all()
    assert Lens((0.1, 0, 0, 0)).undistorted(np.zeros((0, 2)), KINECT).shape == (0, 2)


def test_a_lens_that_folds_the_image_is_known():
    assert Lens((-0.9, 0.0, 0.0, 0.0)).folds(KINECT)
    assert Lens((0.0, 0.0, 0.0, 0.0, -3.0)).folds(KINECT)


@pytest.mark.parametrize("wrong", [(0.1,), (0.1,) * 12, (np.nan, 0, 0, 0), (np.inf, 0, 0, 0), (1e6, 0, 0, 0)])
def test_what_is_no_lens(wrong):
    with pytest.raises(Refused, match="lens distortion"):
        Lens(tuple(float(value) for value in wrong))
