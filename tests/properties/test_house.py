"""Rules of the house that no linter knows."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
PACKAGES = ("rehab_app", "robot_iface", "sessions")
SOURCES = sorted(path for package in PACKAGES for path in (REPOSITORY / package).rglob("*.py"))
TESTS = sorted((REPOSITORY / "tests").rglob("*.py"))
CLOUD_WAYPOINTS = "intermediate" + "_positions"
VAGUE_NAMES = {"utils", "common", "helpers", "base", "manager"}


def relative(path: Path) -> str:
    return str(path.relative_to(REPOSITORY))


def test_the_scan_sees_the_sources() -> None:
    assert len(SOURCES) > 50


@pytest.mark.parametrize("path", SOURCES, ids=relative)
def test_no_waypoints_leave_the_machine(path: Path) -> None:
    assert CLOUD_WAYPOINTS not in path.read_text(), "ruckig's waypoints call a remote service"


@pytest.mark.parametrize("path", SOURCES, ids=relative)
def test_files_and_functions_stay_readable(path: Path) -> None:
    text = path.read_text()
    assert text.count("\n") <= 300, "split the file"
    assert path.stem not in VAGUE_NAMES, "name the noun that lives here"
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            lines = _body_lines(node)
            assert lines <= 40, f"{node.name} has {lines} lines: split it"


@pytest.mark.parametrize("path", TESTS, ids=relative)
def test_files_of_tests_stay_readable(path: Path) -> None:
    assert path.read_text().count("\n") <= 300, "split the file by subject"


def _body_lines(node: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Lines of a function without its docstring: a long contract is welcome, a long body is not."""
    body = node.body[1:] if ast.get_docstring(node) is not None else node.body
    if not body:
        return 0
    end = node.end_lineno or node.lineno
    return end - body[0].lineno + 1


def test_web_assets_hold_no_python() -> None:
    assert not list((REPOSITORY / "web_assets").rglob("*.py"))
