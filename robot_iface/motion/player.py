"""Plays one path coordinate: speed, pause, resume and stop happen along the path and never beside it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ruckig import ControlInterface, InputParameter, OutputParameter, Result, Ruckig, RuckigError

from robot_iface.errors import Refused

MIN_SPEED = 0.05
MAX_SPEED = 1.0


@dataclass(frozen=True, slots=True)
class PathState:
    """Where the player stands.

    Attributes:
        s: Path coordinate in seconds at full speed.
        s_dot: Path speed, 1 is the therapist's own.
        s_ddot: Path acceleration, per second.
        at_end: Whether the end is reached, at rest.
    """

    s: float
    s_dot: float
    s_ddot: float
    at_end: bool


class PathPlayer:
    """One-degree-of-freedom, jerk-limited motion of the path coordinate from 0 to its end.

    While playing, the end of the path is the goal of a position profile whose speed limit is the requested
    speed; while paused, a velocity profile brings the speed to zero. The path coordinate never decreases
    until ``rewind``.

    Args:
        duration_s: Length of the path.
        period_s: Control period.
        speed: First requested speed, 0.05 to 1.
        acceleration: Largest change of path speed, per second.
        jerk: Largest change of path acceleration, per second squared.

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
    ) -> None:
        if not duration_s > 0.0:
            raise Refused("path duration", f"{duration_s} s", "more than 0 s", "rebuild the reference")
        self.duration_s = duration_s
        self.fault = ""
        """What the profile generator refused; the player then brakes by itself and stays stopped."""
        self._period_s = period_s
        self._acceleration = acceleration
        self._ruckig: Any = Ruckig(1, period_s)
        self._input: Any = InputParameter(1)
        self._output: Any = OutputParameter(1)
        self._input.max_acceleration = [acceleration]
        self._input.max_jerk = [jerk]
        self._input.target_velocity = [0.0]
        self._input.target_acceleration = [0.0]
        self._state = PathState(0.0, 0.0, 0.0, False)
        self._paused = False
        self._rested = False
        self._speed = speed
        self.request_speed(speed)
        self.rewind()

    @property
    def paused(self) -> bool:
        """Whether a pause was asked for and not yet resumed."""
        return self._paused

    def request_speed(self, speed: float) -> None:
        """Play at another speed from now on, smoothly.

        Raises:
            Refused: If the speed is outside 0.05 to 1.
        """
        if not MIN_SPEED <= speed <= MAX_SPEED:
            raise Refused("path speed", f"{speed:g}", f"{MIN_SPEED} to {MAX_SPEED}", "choose another speed")
        self._speed = speed
        if not self._paused:
            self.resume()

    def pause(self) -> None:
        """Come to rest on the path as fast as the limits of path acceleration and jerk allow."""
        self._paused = True
        self._rested = False
        self._input.control_interface = ControlInterface.Velocity

    def resume(self) -> None:
        """Go on towards the end at the requested speed."""
        self._paused = False
        self._input.control_interface = ControlInterface.Position
        self._input.max_velocity = [self._speed]
        self._input.target_position = [self.duration_s]

    def rewind(self) -> None:
        """Back to the beginning of the path, for a new repetition.

        Raises:
            Refused: If the path coordinate is still moving.
        """
        if self._state.s_dot > 0.0:
            raise Refused("path player", "moving", "at rest", "pause it and wait before rewinding")
        self._state = PathState(0.0, 0.0, 0.0, False)
        self._input.current_position = [0.0]
        self._input.current_velocity = [0.0]
        self._input.current_acceleration = [0.0]
        if not self._paused:
            self.resume()

    def step(self) -> PathState:
        """Advance by one control period."""
        if self._state.at_end or (self._paused and self._rested):  # rest is exact: no rounding creeps on
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

    def _read(self, finished: bool) -> PathState:
        """State from the generator's output; rounding may neither reverse nor leave the path."""
        if finished and not self._paused:
            return PathState(self.duration_s, 0.0, 0.0, True)
        s = min(max(self._output.new_position[0], self._state.s), self.duration_s)
        if finished:
            return PathState(s, 0.0, 0.0, s >= self.duration_s)
        s_dot = max(self._output.new_velocity[0], 0.0)
        return PathState(s, s_dot, self._output.new_acceleration[0], False)

    def _brake(self) -> PathState:
        """One period of constant deceleration, without the generator."""
        old = self._state
        s_dot = max(old.s_dot - self._acceleration * self._period_s, 0.0)
        s = min(old.s + 0.5 * (old.s_dot + s_dot) * self._period_s, self.duration_s)
        return PathState(s, s_dot, (s_dot - old.s_dot) / self._period_s, False)
