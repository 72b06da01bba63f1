"""An app that is there to be killed or frozen: starts a long run in real time and prints what happens.

Run as a script with the folder of the shared fixtures. Prints the number of the motion process when the hand
moves, then the cause of every safety event.
"""

import sys

sys.path.insert(0, sys.argv[1])
from conftest import fist, make_plan

from robot_iface.errors import Refused
from robot_iface.link import MotionClient
from robot_iface.types import PhaseChange, SafetyEvent

motion = MotionClient()
plan = make_plan(path=fist(1.0, 6.0, 20.0), realtime=True, repetitions=50)
motion.start(plan, motion.rehearse(plan))
told = False
try:
    for message in motion.messages(timeout_s=60.0):
        if isinstance(message, PhaseChange) and message.phase == "move" and not told:
            told = True
            sys.stdout.write(f"{motion.pid}\n")
        if isinstance(message, SafetyEvent):
            sys.stdout.write(f"{message.cause}\n")
        sys.stdout.flush()
except Refused as refused:
    sys.stdout.write(f"{refused}\n")
motion.close()
