"""The options of an order, stated once for every command that plans a session."""

from __future__ import annotations

import functools
import inspect
import math
import typing
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from rehab_app.cli.options import MODES, SPACES, Confirm, Realtime, Robot, Seed, Twin, WristDegrees

if TYPE_CHECKING:
    from rehab_app.services.order import Order

Mode: TypeAlias = Annotated[str, typer.Option("--mode", help=MODES + ".")]
Speed: TypeAlias = Annotated[float, typer.Option("--speed", help="Path speed, 0.1 to 1 of the therapist's.")]
Repetitions: TypeAlias = Annotated[int, typer.Option("--repetitions", help="How many times.")]
Stiffness: TypeAlias = Annotated[
    float | None,
    typer.Option("--stiffness", help="Multiple of the thesis gains, 0.1 to 10.", show_default=False),
]
Space: TypeAlias = Annotated[str, typer.Option("--space", help="Where the impedance acts: " + SPACES + ".")]
WarmUp: TypeAlias = Annotated[int, typer.Option("--warm-up", help="First repetitions with less range.")]
Minutes: TypeAlias = Annotated[
    float, typer.Option("--minutes", help="No repetition begins after this long; 0 for none.")
]
Resistance: TypeAlias = Annotated[
    float, typer.Option("--resistance", help="Resistive: share of the torque limit, 0.05 to 0.8.")
]
Hold: TypeAlias = Annotated[
    float | None,
    typer.Option("--hold-s", help="Hold at the end of a repetition, 0 to 60 s.", show_default=False),
]


def order_of(
    robot: Robot = "exoskeleton",
    mode: Mode = "passive",
    virtual_patient: Twin = "",
    speed: Speed = 0.5,
    repetitions: Repetitions = 3,
    stiffness: Stiffness = None,
    space: Space = "joint",
    warm_up: WarmUp = 0,
    minutes: Minutes = 0.0,
    resistance: Resistance = 0.3,
    hold_s: Hold = None,
    wrist_deg: WristDegrees = 0.0,
    realtime: Realtime = False,
    confirm_device: Confirm = "",
    seed: Seed = 0,
) -> Order:
    """The order that these options say.

    Raises:
        Refused: The seed or the wrist angle is none.
    """
    from rehab_app.services.order import Order

    return Order(
        device=robot,
        mode=mode,
        speed=speed,
        repetitions=repetitions,
        twin=virtual_patient,
        seed=seed,
        stiffness_multiple=stiffness,
        realtime=realtime,
        space=space,
        warm_up=warm_up,
        minutes=minutes,
        resistance=resistance,
        hold_s=hold_s,
        wrist_rad=math.radians(wrist_deg),
        confirmed_device=confirm_device,
    )


def with_order(command: Callable[..., None]) -> Callable[..., None]:
    """A command whose parameter ``order`` is spelled out as the options of ``order_of``."""
    options = _parameters(order_of)
    names = [option.name for option in options]
    own = _parameters(command)
    place = next(index for index, parameter in enumerate(own) if parameter.name == "order")

    @functools.wraps(command)
    def ordered(**given: Any) -> None:
        order = order_of(**{name: given.pop(name) for name in names})
        command(order=order, **given)

    parameters = [*own[:place], *options, *own[place + 1 :]]
    ordered.__dict__["__signature__"] = inspect.Signature(parameters)
    ordered.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    del ordered.__dict__["__wrapped__"]  # typer would read the signature of what is wrapped
    return ordered


def _parameters(function: Callable[..., Any]) -> list[inspect.Parameter]:
    """Parameters with their annotations resolved; ``order`` needs none, nobody types it."""
    hidden = {"Order": object}
    hints: dict[str, Any] = typing.get_type_hints(function, localns=hidden, include_extras=True)
    return [
        parameter.replace(annotation=hints[name], kind=inspect.Parameter.KEYWORD_ONLY)
        for name, parameter in inspect.signature(function).parameters.items()
    ]
