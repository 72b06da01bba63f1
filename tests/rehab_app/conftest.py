"""The two networks of markerless tracking, obtained once as a user would."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from rehab_app.vision.markerless.install import install
from sessions.errors import Refused


@pytest.fixture(scope="session")
def networks() -> Path:
    """Folder of the networks; a skip that says why where no index can be reached, which CI must reach."""
    try:
        return install().folder
    except Refused as refusal:
        if os.environ.get("CI"):
            raise
        pytest.skip(f"the networks are absent: {refusal}")
