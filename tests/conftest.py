"""Fixtures that several suites share."""

from __future__ import annotations

import importlib.util
import os
import sys
from collections.abc import Generator
from pathlib import Path
from types import ModuleType
from typing import Any

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


@pytest.fixture(scope="session")
def s3_module() -> ModuleType:
    """The tests' own S3 server, which lies beside this file."""
    spec = importlib.util.spec_from_file_location("s3_server", Path(__file__).with_name("s3_server.py"))
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["s3_server"] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def s3_gate(s3_module: ModuleType) -> Generator[Any]:
    """A real S3 server on loopback behind a gate that fails as it is told."""
    with s3_module.s3_server() as behind:
        gate = s3_module.Gate(behind)
        yield gate
        gate.close()


@pytest.fixture
def s3(s3_gate: Any, s3_module: ModuleType) -> Any:
    """The gate, open, with one empty bucket."""
    s3_gate.fault, s3_gate.passes = "", 0
    s3_gate.changes.clear()
    s3_module.make_bucket(s3_gate.behind.geturl())
    return s3_gate
