"""MuJoCo, as the rest of this package sees it: a compiled module whose names have no types."""

from __future__ import annotations

from typing import Any

import mujoco as _mujoco

mujoco: Any = _mujoco
