from __future__ import annotations

import numpy as np
import pytest

from rehab_app.hand.retarget_range import within


@pytest.mark.parametrize(("low", "high"), [(0.0, 1.5), (-0.2, 0.4), (0.1, 0.12)])
def test_a_bounded_path_is_strictly_inside_and_smooth(low: float, high: float) -> None:
    wish = np.linspace(-3, 3, 6001)
    path = within(wish, low, high)
    assert low < path.min()
    assert path.max() < high
    assert (np.diff(path) >= 0).all()
    assert np.abs(np.diff(path, 2)).max() / 0.001**2 < 2 / min(np.deg2rad(1.0), (high - low) / 12)


def test_the_middle_of_the_range_is_left_alone() -> None:
    wish = np.linspace(np.deg2rad(6), np.deg2rad(84), 50)
    np.testing.assert_allclose(within(wish, 0.0, np.deg2rad(90)), wish, atol=np.deg2rad(0.02))
