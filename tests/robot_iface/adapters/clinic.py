"""The whole app's side: starts the motion process, which moves a real device. Prints a JSON line per event.

Run as a script with one argument, JSON: ``device``, ``confirmed``. Device files are found by the environment.
"""

import json
import sys
from dataclasses import replace

from app import MULTIPLE, Teller, shared_suite

from robot_iface.errors import Refused
from robot_iface.link import MotionClient


def main(device: str, confirmed: str) -> None:
    suite, teller = shared_suite(), Teller()
    path = suite.fist(1.0, 12.0, 8.0)
    plan = suite.make_plan(path=path, repetitions=50, realtime=True, multiple=MULTIPLE)
    plan = replace(plan, device=device, confirmed_device=confirmed)
    try:
        with MotionClient() as motion:
            motion.start(plan, motion.rehearse(plan))
            for message in motion.messages():
                teller(message)
    except Refused as refused:
        teller.say(refused=str(refused))


if __name__ == "__main__":
    main(**json.loads(sys.argv[1]))
