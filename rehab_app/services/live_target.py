"""The target grip of the live page: what the therapist chose, laid over the live picture."""

from __future__ import annotations

from dataclasses import replace

from rehab_app.access import Account, require
from rehab_app.services.audit import Audit
from rehab_app.services.grip_finder import GripFinder
from rehab_app.services.grip_target import GripChoice, WayToGo, way_to_go
from rehab_app.services.snapshot import LiveSnapshot

_NOT_WHILE = ("countdown", "recording", "processing")


class LiveTarget:
    """The chosen grip; it is shown before, during and after a session, and it moves nothing.

    Args:
        audit: Where choices are noted.
    """

    def __init__(self, audit: Audit) -> None:
        self._audit = audit
        self._finder = GripFinder()
        self._choice: GripChoice | None = None  # read without a lock by every picture: one attribute access

    @property
    def choice(self) -> GripChoice | None:
        """What was chosen, None for no target."""
        return self._choice

    def choose(self, account: Account, choice: GripChoice | None) -> None:
        """Show another target from now on, or none.

        Args:
            account: Who chooses.
            choice: Object and grip, None for no target.

        Raises:
            Refused: The role may not play.
        """
        require(account, "play")
        self._choice = choice
        self._audit.note_later(account.name, "target grip", detail="none" if choice is None else choice.words)

    def onto(self, shown: LiveSnapshot) -> LiveSnapshot:
        """The same picture with the target for the hand in it; a demonstration is recorded without."""
        choice = self._choice
        if choice is None or shown.state in _NOT_WHILE:
            return shown
        return replace(shown, grip=self._finder.find(choice, shown.geometry))


def way_of(shown: LiveSnapshot) -> WayToGo | None:
    """How far the hand that moves is from the target: the patient's, or the robot's own; None without one."""
    target, joints = shown.grip.target, shown.patient_joints_rad
    return None if target is None or joints is None else way_to_go(target, joints, worn=shown.worn)
