"""Fixtures that several suites share."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import settings

# As in the product's own entry points: threads of the linear algebra only get in each other's way on matrices
# this small. Test modules, which import numpy, are loaded after this file.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Every run draws the same examples: a red build is the change's doing, never the dice's.
settings.register_profile("seeded", derandomize=True, deadline=None)
settings.load_profile("seeded")

REPOSITORY = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder of the real recordings, or a skip that says how to provide it."""
    folder = Path(os.environ.get("REHAB_SHARED_DATA", REPOSITORY.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip("real recordings are absent: set REHAB_SHARED_DATA to their folder")
    return folder
