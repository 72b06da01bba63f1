"""The app's side of a run on a real device, as a process of its own. Prints a JSON line per phase and event.

Run as a script with one argument, JSON: ``folder``, ``device``, ``depth_deg``, ``repetitions``.
"""

import importlib.util
import json
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from robot_iface.adapters.ros2 import open_ros2
from robot_iface.errors import Refused
from robot_iface.loop import RealTimeClock, request_realtime_priority
from robot_iface.runtime import PresentPatient, Rig, ScriptedInbox, Surroundings, perform
from robot_iface.types import PhaseChange, RunEnd, SafetyEvent, TickBlock

MULTIPLE = 0.5
"""The stiffest that 10 ms allow a joint of little inertia."""


def shared_suite() -> Any:
    """The fixtures that the suites of the motion core share."""
    path = Path(__file__).parents[1] / "conftest.py"
    found = importlib.util.spec_from_file_location("motion_suite", path)
    assert found is not None
    assert found.loader is not None
    module = importlib.util.module_from_spec(found)
    sys.modules[found.name] = module
    found.loader.exec_module(module)
    return module


class Teller:
    """Receives a run's messages and prints what the test needs of them."""

    def __init__(self) -> None:
        self.t_ns: list[int] = []
        self.q_rad: list[Any] = []
        self.stale: SafetyEvent | None = None

    def __call__(self, message: Any) -> None:
        match message:
            case PhaseChange():
                self.say(phase=message.phase)
            case SafetyEvent():
                self.say(cause=message.cause, state=message.state.name)
                self.stale = message if message.cause == "device-stale" else self.stale
            case TickBlock():
                self.t_ns.extend(message.t_ns.tolist())
                self.q_rad.append(message.q_rad)
            case RunEnd():
                self.say(**self.summary(message))

    def summary(self, end: RunEnd) -> dict[str, Any]:
        travel = np.rad2deg(np.ptp(np.concatenate(self.q_rad), axis=0)).round(2).tolist()
        found: dict[str, Any] = {"end": end.state.name, "completed": end.completed, "travel_deg": travel}
        if self.stale is not None:
            since_ns = self.stale.t_ns - round(self.stale.value * 1e9)
            found["stale_ticks"] = sum(since_ns < t_ns <= self.stale.t_ns for t_ns in self.t_ns)
        return found

    @staticmethod
    def say(**line: Any) -> None:
        sys.stdout.write(json.dumps(line) + "\n")
        sys.stdout.flush()


class NeverPressed:
    def pressed(self) -> bool:
        return False


def main(folder: str, device: str, depth_deg: float = 20.0, repetitions: int = 1) -> None:
    suite, teller = shared_suite(), Teller()
    started_s = time.monotonic()
    try:
        hand = open_ros2(device, Path(folder))
        path = suite.fist(1.0, depth_deg, 8.0)
        plan = replace(
            suite.make_plan(path=path, repetitions=repetitions, multiple=MULTIPLE),
            device=hand.capabilities.name,
            confirmed_device=hand.capabilities.name,
            realtime=True,
        )
        rig = Rig(hand, RealTimeClock(hand.capabilities.period_ns), PresentPatient())
        request_realtime_priority()
        perform(plan, rig, Surroundings(NeverPressed(), teller, ScriptedInbox()))
    except Refused as refused:
        teller.say(refused=str(refused), after_s=time.monotonic() - started_s)


if __name__ == "__main__":
    main(**json.loads(sys.argv[1]))
