"""The rigid hand of the safety tests, for the hazards."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from typing import Any

import pytest

SOURCE = Path(__file__).resolve().parents[1] / "robot_iface" / "safety" / "rigid_hand.py"


@pytest.fixture(scope="session")
def rigid() -> Any:
    """Module with RigidHand and Rig."""
    name = "rehab_tests_rigid_hand"
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, SOURCE)
        assert spec is not None
        assert spec.loader is not None
        sys.modules[name] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(sys.modules[name])
    return sys.modules[name]
