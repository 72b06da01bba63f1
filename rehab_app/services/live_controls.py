"""What a person may ask of the run that goes on: hold, go on, go back, next, faster, slower."""

from __future__ import annotations

from collections.abc import Callable

from rehab_app.access import Account, require
from rehab_app.errors import Refused
from rehab_app.services.audit import Audit
from rehab_app.services.live_therapy import TherapyJob


class LiveControls:
    """The verbs of a run. Each returns at once and leaves an audit row.

    Making the run safer (hold it, slow it down) is anybody's; whatever else asks for the role.

    Args:
        running: Gives the run that goes on, None where there is none.
        audit: Where every verb is noted.
    """

    def __init__(self, running: Callable[[], TherapyJob | None], audit: Audit) -> None:
        self._running = running
        self._audit = audit

    def pause(self, account: Account) -> None:
        """Hold the path; anybody may.

        Raises:
            Refused: Nothing is played; so for every verb here.
        """
        self._going_on("pause").pause()
        self._note(account, "pause")

    def resume(self, account: Account) -> None:
        """Go on along the path; after a skin check, the skin has been looked at."""
        self._run(account, "resume").resume()
        self._note(account, "resume")

    def reverse(self, account: Account) -> None:
        """Go back along the path, to its start at most; in a sweep, back to the relaxed hand.

        Raises:
            Refused: As of ``pause``, the role may not play, or the movement is held.
        """
        self._run(account, "reverse").reverse()
        self._note(account, "reverse")

    def advance(self, account: Account) -> None:
        """Go on to the next repetition or posture, or let the robot help."""
        self._run(account, "next").advance()
        self._note(account, "next")

    def set_speed(self, account: Account, speed: float) -> None:
        """Ask for another path speed, 0.1 to 1; anybody may slow it down.

        Raises:
            Refused: As of ``pause``, the speed is out of bounds, or it is raised by a role that may not play.
        """
        job = self._going_on("speed")
        if not speed <= job.speed:
            require(account, "play")
        if not 0.1 <= speed <= 1.0:
            raise Refused("speed", f"{speed:g}", "0.1 to 1", "choose a speed within it")
        job.set_speed(speed)
        self._note(account, "set speed", f"{speed:g}")

    def _run(self, account: Account, verb: str) -> TherapyJob:
        require(account, "play")
        return self._going_on(verb)

    def _going_on(self, verb: str) -> TherapyJob:
        job = self._running()
        if job is None:
            raise Refused(
                verb, "asked for while nothing is played", "during a session", "start a session first"
            )
        return job

    def _note(self, account: Account, verb: str, detail: str = "") -> None:
        self._audit.note_later(account.name, verb, detail=detail)
