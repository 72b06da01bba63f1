"""An exercise along a path, as a run sees it: one step a tick, and what a person may ask of it."""

from __future__ import annotations

from robot_iface.control import Goal
from robot_iface.errors import Refused
from robot_iface.motion import PathState, Transfer
from robot_iface.runtime.exercise_phases import ExercisePhases
from robot_iface.runtime.guidance import APPROACH_MULTIPLE
from robot_iface.runtime.reversals import Verdict
from robot_iface.runtime.task import Remark
from robot_iface.types import DeviceState, Float64

_MIN_SPEED = 0.1
_LONG_RESTS = ("rest-proposed", "skin-check")
_QUIET = ("ramp", "return", "rest", *_LONG_RESTS)


class Exercise(ExercisePhases):
    """The sequence of phases over all repetitions, advanced once a tick. Implements ``Task``."""

    @property
    def done(self) -> bool:
        """Whether there is nothing left to do and the hand is back."""
        return self.phase == "done"

    @property
    def paused(self) -> bool:
        """Whether a pause was asked for and not yet resumed."""
        return self._movement.player.paused

    @property
    def fault(self) -> str:
        """What the path player refused; empty while it plays."""
        way = self._way or self._back
        return self._movement.player.fault or way.fault

    @property
    def path_state(self) -> PathState:
        """Where the path stands."""
        return self._movement.state

    @property
    def reference_rad(self) -> Float64:
        """The therapist's posture at the present path coordinate, (J,)."""
        movement = self._movement
        return movement.here_rad if self.phase in ("move", "hold") else movement.start.q_rad

    @property
    def stiffness_multiple(self) -> Float64:
        """Stiffness of the last tick as a multiple of the thesis gains, (J,)."""
        return self._guidance.shaper.multiple.copy()

    @property
    def assistance(self) -> tuple[tuple[float, ...], ...]:
        """Assistance reached, as ``Prescription.assistance``; empty where there is none."""
        return self._guidance.assistance

    @property
    def repetition_age_ns(self) -> int:
        """How long this repetition has been going on, pauses left out; 0 outside one."""
        return self._dose.repetition_ns

    @property
    def repetition_timeout_ns(self) -> int:
        """How long it may take."""
        return self._dose.timeout_ns

    def take_remark(self) -> Remark | None:
        """What is to be recorded, or to be held for, since the last tick."""
        return self._remarks.popleft() if self._remarks else None

    def begin(self, q_rad: Float64) -> None:
        """Plan the way from where the hand is, (J,), to where it should be: at first, and after a hold."""
        goal = q_rad if self._guidance.lets_go(self.phase) else self.reference_rad
        self._way = Transfer(q_rad, goal, self._plan.limits, self._period_s)
        if self.phase == "return":
            self._back.skip()
        self._guidance.shaper.begin_anew(APPROACH_MULTIPLE)

    def resting_goal(self) -> Goal:
        """The start of the path, without stiffness: a goal before the first step."""
        return self._guidance.resting_goal()

    def step(self, state: DeviceState, load_share: float, active: bool) -> Goal:
        """What this tick asks for.

        Args:
            state: Newest reading.
            load_share: Largest interaction torque as a share of its limit, one tick ago.
            active: Whether the supervisor has finished its own ramp; until then the hand is held where it is.
        """
        way = self._way
        moving = not (self._movement.player.paused or self.phase in _LONG_RESTS)
        self._dose.tick(moving=moving, repeating=moving and way is None and self.repetition >= 0)
        if way is not None:
            return self._on_the_way(way, state, active)
        self._ticks += 1
        self._drift.watch(state, quiet=not self._waits or self.phase in _QUIET)
        setpoint = self._steps[self.phase](state, load_share)
        return self._guidance.goal(
            "probe" if self._probes and self.phase == "rest" else self.phase, setpoint, state
        )

    def _on_the_way(self, way: Transfer, state: DeviceState, active: bool) -> Goal:
        """A tick between where the hand was and where it should be."""
        setpoint = way.step(paused=self._movement.player.paused) if active else way.start
        if way.done:
            self._way = None
        self._drift.watch(state, quiet=True)
        return self._guidance.along(setpoint, state)

    def pause(self) -> None:
        """Come to rest on the path."""
        self._movement.player.pause()

    def resume(self) -> None:
        """Go on; after a skin check, the skin has been looked at."""
        self._movement.player.resume()
        if self.phase == "skin-check":
            self._dose.skin_checked()
            self._next_repetition()

    def reverse(self) -> None:
        """Go back along the path, to its start at most; where the path is not being played, a pause."""
        if self._way is None and self.phase in ("move", "hold"):
            self._enter("move")
            self._movement.player.reverse()
        elif self.phase != "return":
            self.pause()

    def advance(self) -> None:
        """A person asks for what comes next: the end of a rest or a hold, or the robot's help in a cue.

        Raises:
            Refused: The hand is being moved.
        """
        if self.paused or self._way is not None or self.phase not in ("cue", "hold", "rest", "rest-proposed"):
            bound = "while the hand rests, is held or is waited for"
            raise Refused("next repetition", f"asked for in {self.phase}", bound, "wait for the rest")
        if self.phase == "cue":
            self._set_off("robot")
        elif self.phase == "hold":
            self._go_back()
        else:
            self._follow(self._schedule.after_rest())

    def slow_down_to(self, speed: float) -> None:
        """Play at this path speed, but never faster than was prescribed and rehearsed."""
        speed = min(max(speed, _MIN_SPEED), self._ordered.speed)
        self._dose.slowed_to(speed)
        self._movement.player.request_speed(speed)

    def trouble(self) -> None:
        """Pain, or a latched hold, in this repetition: nothing is learnt from it and help is not raised."""
        self._guidance.trouble()

    def reversed_on_load(self, q_rad: Float64) -> None:
        """The supervisor has gone back on a load: the repetition is given up, the hand led back from here.

        The second in five repetitions takes 5 degrees off the range; a third ends the run.
        """
        verdict = self._schedule.reversals.note(reversed_on_load=True)
        guidance, movement = self._guidance, self._movement
        guidance.trouble()
        guidance.shaper.begin_anew(APPROACH_MULTIPLE)
        if verdict is Verdict.STOP:
            self.reason = "reversals"
            return
        if verdict is Verdict.NARROW:
            movement.cut()
            self._remarks.append(Remark("range-narrowed"))
        if self.phase in ("cue", "move", "hold"):
            guidance.finish_repetition(reversed_on_load=True)
        movement.give_up()
        movement.prepare(max(self.repetition, 0))
        self._patient.relax()
        if self.repetition < 0 or self._way is not None:
            self.begin(q_rad)
        else:
            self._back = self._lead(q_rad)
            self._enter("return")
