"""The rigid hand and its rig, for every test of safety."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from typing import Any

import pytest

SOURCE = Path(__file__).with_name("rigid_hand.py")


def load_rigid_hand() -> Any:
    """The module of the rigid hand; tests are no package, so it is loaded by its path, once."""
    name = "rehab_tests_rigid_hand"
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, SOURCE)
        assert spec is not None
        assert spec.loader is not None
        sys.modules[name] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(sys.modules[name])
    return sys.modules[name]


@pytest.fixture(scope="session")
def rigid() -> Any:
    """Module with RigidHand and Rig."""
    return load_rigid_hand()
