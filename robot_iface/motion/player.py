"""Plays one path coordinate: speed, pause, resume, reverse and stop happen along the path."""

from __future__ import annotations

from enum import IntEnum
from typing import Any, NamedTuple

from ruckig import ControlInterface, InputParameter, OutputParameter, Result, Ruckig, RuckigError

from robot_iface.errors import Refused

MIN_SPEED = 0.05
MAX_SPEED = 1.0
_SLOWEST_BACK = 1e-3
_STILL = 1e-12


class PathState(NamedTuple):
    """Where the player stands.

    Attributes:
        s: Path coordinate in seconds at full speed.
        s_dot: Path speed, 1 is the therapist's own; negative on the way back.
        s_ddot: Path acceleration, per second.
        at_end: Whether the end is reached, at rest.
    """

    s: float
    s_dot: float
    s_ddot: float
    at_end: bool


AT_START = PathState(0.0, 0.0, 0.0, False)


class Heading(IntEnum):
    """What is asked of the player."""

    BACK = -1
    REST = 0
    ON = 1


class PathPlayer:
    """One-degree-of-freedom, jerk-limited motion of the path coordinate between 0 and its end.

    Going on, the end of the path is the goal of a position profile whose speed limit is the requested
    speed; going back, the start is, with a limit of its own; to rest, a velocity profile brings the speed to
    zero. Any of the three may be asked for at any time. No profile overshoots: where the speed can be
    brought to zero before an end, so it can one tick later.

    Args:
        duration_s: Length of the path.
        period_s: Control period.
        speed: First requested speed, 0.05 to 1.
        acceleration: Largest change of path speed, per second.
        jerk: Largest change of path acceleration, per second squared.
        back_speed: Highest speed on the way back; it is never faster than the requested speed.

    Raises:
        Refused: If the duration or the speed cannot be played.
    """

    def __init__(
        self,
        duration_s: float,
        period_s: float,
        speed: float = 0.5,
        acceleration: float = 2.0,
        jerk: float = 20.0,
        back_speed: float = MAX_SPEED,
    ) -> None:
        if not duration_s > 0.0:
            raise Refused("path duration", f"{duration_s} s", "more than 0 s", "rebuild the reference")
        self.duration_s = duration_s
        self.fault = ""
        """What the profile generator refused; the player then brakes by itself and stays stopped."""
        self._period_s = period_s
        self._acceleration = acceleration
        self._back_speed = max(back_speed, _SLOWEST_BACK)
        self._ruckig: Any = Ruckig(1, period_s)
        self._input: Any = InputParameter(1)
        self._output: Any = OutputParameter(1)
        self._input.max_acceleration = [acceleration]
        self._input.max_jerk = [jerk]
        self._input.target_velocity = [0.0]
        self._input.target_acceleration = [0.0]
        self._state = AT_START
        self._heading = Heading.ON
        self._rested = False
        self._speed = speed
        self.request_speed(speed)
        self.rewind()

    @property
    def state(self) -> PathState:
        """Where the player stands."""
        return self._state

    @property
    def paused(self) -> bool:
        """Whether a pause or the way back was asked for and not yet resumed."""
        return self._heading is not Heading.ON

    def request_speed(self, speed: float) -> None:
        """Play at another speed from now on, smoothly.

        Raises:
            Refused: If the speed is outside 0.05 to 1.
        """
        if not MIN_SPEED <= speed <= MAX_SPEED:
            raise Refused("path speed", f"{speed:g}", f"{MIN_SPEED} to {MAX_SPEED}", "choose another speed")
        self._speed = speed
        self._go(self._heading)

    def pause(self) -> None:
        """Come to rest on the path as fast as the limits of path acceleration and jerk allow."""
        self._go(Heading.REST)

    def resume(self) -> None:
        """Go on towards the end at the requested speed."""
        self._go(Heading.ON)

    def reverse(self) -> None:
        """Go back along the path, to its start at most; ``resume`` goes on again."""
        self._go(Heading.BACK)

    def rewind(self) -> None:
        """Back to the beginning of the path, for a new repetition.

        Raises:
            Refused: If the path coordinate is still moving.
        """
        if self._state.s_dot != 0.0:
            raise Refused("path player", "moving", "at rest", "pause it and wait before rewinding")
        self.abandon()

    def abandon(self) -> None:
        """Stand at the beginning, at rest, although it was elsewhere: the hand is led by something else."""
        self._state = AT_START
        self._input.current_position = [0.0]
        self._input.current_velocity = [0.0]
        self._input.current_acceleration = [0.0]
        self._go(self._heading)

    def step(self) -> PathState:
        """Advance by one control period."""
        if self._rested:  # rest is exact: no rounding creeps on
            return self._state
        if self.fault:
            self._state = self._brake()
            return self._state
        try:
            result = self._ruckig.update(self._input, self._output)
        except (RuckigError, ValueError) as error:
            self.fault = str(error)
            return self.step()
        if result not in (Result.Working, Result.Finished):
            self.fault = str(result)
            return self.step()
        self._output.pass_to_input(self._input)
        self._rested = result == Result.Finished
        self._state = self._read(self._rested)
        return self._state

    def _go(self, heading: Heading) -> None:
        """Take a heading; speeds are bounded by direction, whatever is going on."""
        self._heading = heading
        self._rested = False
        order = self._input
        if heading is Heading.REST:
            order.control_interface = ControlInterface.Velocity
            return
        order.control_interface = ControlInterface.Position
        order.max_velocity = [self._speed]
        order.min_velocity = [-min(self._speed, self._back_speed)]
        order.target_position = [self.duration_s if heading is Heading.ON else 0.0]

    def _read(self, finished: bool) -> PathState:
        """State from the generator's output; rounding may not leave the path."""
        if finished and self._heading is not Heading.REST:
            if self._heading is Heading.BACK:
                return AT_START
            return PathState(self.duration_s, 0.0, 0.0, True)
        output = self._output
        s = min(max(output.new_position[0], 0.0), self.duration_s)
        if finished:
            return PathState(s, 0.0, 0.0, s >= self.duration_s)
        s_dot = output.new_velocity[0]
        return PathState(s, s_dot if abs(s_dot) > _STILL else 0.0, output.new_acceleration[0], False)

    def _brake(self) -> PathState:
        """One period of constant deceleration, without the generator."""
        old, step = self._state, self._acceleration * self._period_s
        s_dot = max(old.s_dot - step, 0.0) if old.s_dot > 0.0 else min(old.s_dot + step, 0.0)
        s = min(max(old.s + 0.5 * (old.s_dot + s_dot) * self._period_s, 0.0), self.duration_s)
        return PathState(s, s_dot, (s_dot - old.s_dot) / self._period_s, False)
