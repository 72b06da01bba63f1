from __future__ import annotations

import cv2
import numpy as np
import pytest

from rehab_app.vision.components import connected_parts


def partition(row: np.ndarray, column: np.ndarray, owner: np.ndarray) -> set[frozenset[tuple[int, int]]]:
    groups: dict[int, set[tuple[int, int]]] = {}
    for r, c, o in zip(row, column, owner, strict=True):
        groups.setdefault(int(o), set()).add((int(r), int(c)))
    return {frozenset(group) for group in groups.values()}


@pytest.mark.parametrize("density", [0.05, 0.3, 0.5, 0.7, 1.0])
@pytest.mark.parametrize("seed", range(6))
def test_parts_are_those_of_a_full_labelling(seed: int, density: float) -> None:
    rng = np.random.default_rng(seed)
    mask = rng.random((int(rng.integers(1, 40)), int(rng.integers(1, 40)))) < density
    parts = connected_parts(mask)
    count, labels = cv2.connectedComponents(mask.astype(np.uint8), connectivity=8)
    assert parts.count == count - 1
    rows, columns = np.nonzero(labels)
    wanted = partition(rows, columns, np.asarray(labels)[rows, columns])
    assert partition(parts.row, parts.column, parts.owner) == wanted


def test_a_spiral_is_one_part() -> None:
    mask = np.zeros((41, 41), dtype=bool)
    for ring in range(0, 20, 2):
        mask[ring, ring : 41 - ring] = mask[41 - ring - 1, ring : 41 - ring] = True
        mask[ring : 41 - ring, 41 - ring - 1] = mask[ring + 2 : 41 - ring, ring] = True
        mask[ring + 2, ring : ring + 3] = True
    assert (
        connected_parts(mask).count == cv2.connectedComponents(mask.astype(np.uint8), connectivity=8)[0] - 1
    )


def test_chosen_parts_keep_their_pixels() -> None:
    mask = np.zeros((9, 9), dtype=bool)
    mask[1, 1] = mask[4, 4:7] = mask[8, 0] = True
    parts = connected_parts(mask).only(np.array([True, False, True]))
    assert parts.count == 2
    assert list(zip(parts.row, parts.column, parts.owner, strict=True)) == [(1, 1, 0), (8, 0, 1)]


def test_nothing_has_no_parts() -> None:
    assert connected_parts(np.zeros((5, 5), dtype=bool)).count == 0
