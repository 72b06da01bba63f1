"""The one place in which whatever a user can cause becomes a sentence and an exit code."""

from __future__ import annotations

import os
import sys
from typing import Any

import typer
from typer.core import TyperGroup

from rehab_app.cli.output import Output, json_line
from rehab_app.errors import REFUSALS, Refused, RobotRefused

_JSON = "rehab_app.json"


class Commands(TyperGroup):
    """A group of commands whose refusals end in exit code 1, one sentence, and JSON if asked for."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Remember whether JSON was asked for before the arguments go to their command."""
        ctx.meta.setdefault(_JSON, "--json" in args)
        return super().parse_args(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        """Run the command; turn refusals and system errors into a sentence.

        Raises:
            typer.Exit: With code 1 where something was refused or failed.
        """
        if ctx.parent is not None:
            return super().invoke(ctx)
        try:
            return super().invoke(ctx)
        except REFUSALS as refusal:
            error = refusal
        except KeyboardInterrupt:
            error = Refused("command", "interrupted", "left to finish", "run it again")
        except BrokenPipeError:
            # nobody reads stdout any more; keep the interpreter from complaining about it at exit
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise typer.Exit(1) from None
        except OSError as problem:
            error = _of_system(problem)
        _tell(error, bool(ctx.meta[_JSON]))
        raise typer.Exit(1)


def _of_system(problem: OSError) -> Refused:
    """A system error, such as a full disk or a missing permission, as a refusal."""
    return Refused(
        str(problem.filename or "the system"),
        f"not usable ({problem.strerror or problem})",
        "readable and writable with space left",
        "check the path, its permissions and the free space",
    )


def _tell(error: Refused | RobotRefused, as_json: bool) -> None:
    if as_json:
        content = {
            "thing": error.thing,
            "value": error.value,
            "bound": error.bound,
            "remedy": error.remedy,
            "message": str(error),
        }
        sys.stdout.write(json_line({"error": content}))
        sys.stdout.flush()
    Output(False).say(str(error))
