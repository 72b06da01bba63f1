"""What is asked for, in words of the command line and the live page; checked before anything is fitted."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from rehab_app.errors import Refused
from robot_iface.types import MODES, SPACES, VIRTUAL_KINDS, Mode, Prescription, Space, VirtualKind

EXOSKELETON = "exoskeleton"
WRIST_LIMIT_RAD = math.radians(80.0)
_LARGEST_SEED = 2**63 - 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Order:
    """An order for one session.

    Attributes:
        device: Device name.
        mode: Therapy mode.
        speed: Path speed, 0.1 to 1 of the therapist's own.
        repetitions: How many times.
        twin: Kind of the virtual patient; empty for what the clinical record says, else healthy.
        seed: Seed of everything random in the simulation.
        stiffness_multiple: Multiple of the thesis gains, None for the default and for what is remembered.
        realtime: On the wall clock.
        space: Where the impedance acts, "joint" or "fingertip".
        warm_up: First repetitions with less range.
        minutes: Time after which no repetition begins, 0 for none.
        resistance: Resistive: share of the interaction limit.
        hold_s: Time held at the end of each repetition, None for the default.
        wrist_rad: Wrist extension at which the hand is held.
        confirmed_device: The real device that a person has confirmed, by its name; empty for a simulation.

    Raises:
        Refused: The seed or the wrist angle is none.
    """

    device: str = EXOSKELETON
    mode: str = "passive"
    speed: float = 0.5
    repetitions: int = 3
    twin: str = ""
    seed: int = 0
    stiffness_multiple: float | None = None
    realtime: bool = False
    space: str = "joint"
    warm_up: int = 0
    minutes: float = 0.0
    resistance: float = 0.3
    hold_s: float | None = None
    wrist_rad: float = 0.0
    confirmed_device: str = ""

    def __post_init__(self) -> None:
        if not 0 <= self.seed <= _LARGEST_SEED:
            raise Refused("seed", str(self.seed), f"0 to {_LARGEST_SEED}", "choose another")
        check_wrist(self.wrist_rad)

    def named_mode(self) -> Mode:
        """The mode.

        Raises:
            Refused: There is none of that name.
        """
        for mode in MODES:
            if mode == self.mode:
                return mode
        raise _unknown("mode", self.mode, MODES)

    def named_twin(self, otherwise: VirtualKind) -> VirtualKind:
        """The kind of virtual patient that is asked for, else the given one.

        Raises:
            Refused: There is none of that name.
        """
        if not self.twin:
            return otherwise
        for kind in VIRTUAL_KINDS:
            if kind == self.twin:
                return kind
        raise _unknown("virtual patient", self.twin, VIRTUAL_KINDS)

    def prescription(
        self, assistance: tuple[tuple[float, ...], ...] = (), skin_check_s: float = 0.0
    ) -> Prescription:
        """The order as the motion core takes it.

        Args:
            assistance: Assistance to begin with, see ``Prescription``.
            skin_check_s: Motion time between looks at the skin.

        Raises:
            Refused: A word or number is out of bounds, or the warm-up never ends.
        """
        if self.warm_up > self.repetitions >= 1:
            raise Refused(
                "warm-up",
                f"{self.warm_up} of {self.repetitions} repetitions",
                "no more than there are repetitions",
                "shorten the warm-up or make more repetitions",
            )
        asked = Prescription(
            self.named_mode(),
            speed=self.speed,
            repetitions=self.repetitions,
            space=self._named_space(),
            warm_up_repetitions=self.warm_up,
            minutes=self.minutes,
            resistance=self.resistance,
            assistance=assistance,
            skin_check_s=skin_check_s,
        )
        if self.hold_s is not None:
            asked = replace(asked, hold_s=self.hold_s)
        if self.stiffness_multiple is not None:
            asked = replace(asked, stiffness_multiple=self.stiffness_multiple)
        return asked

    def _named_space(self) -> Space:
        for space in SPACES:
            if space == self.space:
                return space
        raise _unknown("space", self.space, SPACES)


def check_wrist(wrist_rad: float) -> None:
    """Refuse a wrist that no hand has.

    Raises:
        Refused: It is not within 80 degrees of straight.
    """
    if not abs(wrist_rad) <= WRIST_LIMIT_RAD:
        bound = f"{-math.degrees(WRIST_LIMIT_RAD):.0f} to {math.degrees(WRIST_LIMIT_RAD):.0f} degrees"
        raise Refused(
            "wrist angle", f"{math.degrees(wrist_rad):g} degrees", bound, "measure the wrist's extension"
        )


def _unknown(thing: str, value: str, known: tuple[str, ...]) -> Refused:
    return Refused(thing, repr(value[:40]), "one of " + ", ".join(known), "choose one of them")


PLAIN = Order()
"""Three repetitions, passive, at half the therapist's speed, on the simulated exoskeleton."""
