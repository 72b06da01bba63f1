"""Work in a process of its own, so that a report never delays the server's event loop or the live picture."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Callable
from typing import Any, TypeVar

from rehab_app.errors import REFUSALS, Refused

PATIENCE_S = 300.0
_NICE = 10
Result = TypeVar("Result")


def aside(function: Callable[..., Result], *arguments: Any) -> Result:
    """Call a function in a process that ends with it; blocks this thread only.

    Args:
        function: A function at the top of a module.
        arguments: What it is called with.

    Raises:
        Refused: As the function does; or the process failed, or took longer than five minutes.
    """
    asked = pickle.dumps((function, arguments))
    try:
        done = subprocess.run(
            [sys.executable, "-m", "rehab_app.services.aside"],
            input=asked,
            stdout=subprocess.PIPE,
            timeout=PATIENCE_S,
            env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise _failed(f"not written after {PATIENCE_S:.0f} s") from error
    if done.returncode != 0:
        raise _failed(f"not written (its process ended with {done.returncode})")
    refusal, answer = pickle.loads(done.stdout)  # made by this very program, below
    if refusal is not None:
        raise Refused(*refusal)
    result: Result = answer
    return result


def _answer() -> None:
    """What the process does: one call, read from standard input, answered on standard output."""
    os.nice(_NICE)
    function, arguments = pickle.loads(sys.stdin.buffer.read())
    try:
        answer: tuple[Any, Any] = (None, function(*arguments))
    except REFUSALS as error:
        answer = ((error.thing, error.value, error.bound, error.remedy), None)
    sys.stdout.buffer.write(pickle.dumps(answer))


def _failed(value: str) -> Refused:
    return Refused("report", value, "a report", "try again; the server's log says why it failed")


if __name__ == "__main__":
    _answer()
