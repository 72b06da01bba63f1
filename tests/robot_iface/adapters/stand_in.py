"""A hand behind a ROS 2 driver, as a process of its own: rigid joints, and firmware that watches over them.

It speaks DDS by itself and knows of the app only the device file and the wire format. Run as a script with
one argument, JSON: ``folder``, ``device``, and options (``Options``). Prints one JSON line per event.
"""

import json
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

from robot_iface.adapters import ros2_messages as ros
from robot_iface.adapters.device_file import read_device
from robot_iface.adapters.ros2_bus import dds_configuration
from robot_iface.loop import request_realtime_priority

STEP_S = 1e-3
STEPS_A_LOOK = 5
LOOKS_BEFORE_VANISHING = 400
LOOKS_UNDER_WAY = 10
BRAKE_NMS_RAD = 0.15
SERVO_DAMPING_NMS_RAD = 0.02
QOS = Qos(
    Policy.Reliability.Reliable(0),
    Policy.History.KeepLast(1),
    Policy.DataRepresentation(use_cdrv0_representation=True),
)


@dataclass
class Options:
    folder: str
    device: str
    watchdog_s: float = 0.05
    damping_nms_rad: float = 0.02
    start_deg: float = 8.0
    rename: str = ""
    silent: bool = False
    deaf: bool = False
    rival: bool = False
    no_velocity: bool = False
    fault: str = ""
    vanish: bool = False


class StandIn:
    def __init__(self, options: Options) -> None:
        self.options = options
        self.device = device = read_device(options.device, Path(options.folder))
        network, topics = device.network, device.topics
        self.domain = Domain(network.domain, dds_configuration(network))
        self.participant = participant = DomainParticipant(network.domain)
        kind: Any = ros.Float64MultiArray if device.command == "effort" else ros.JointTrajectory
        self.state = self.writer(topics.state, ros.JointState)
        self.faults = self.writer(topics.faults, ros.String)
        if not options.deaf:
            self.command = self.reader(topics.command, kind)
            self.power = self.reader(topics.power, ros.Bool)
            self.clear = self.reader(topics.clear, ros.Bool)
        if options.rival:
            other = self.other = DomainParticipant(network.domain)
            self.rival = DataWriter(other, Topic(other, f"rt/{topics.command}", kind), qos=QOS)
        del participant
        rows = device.joint
        self.names = [options.rename if options.rename and not i else row.ros for i, row in enumerate(rows)]
        self.sign = np.array([row.sign for row in rows], dtype=float)
        self.offset = np.deg2rad([row.offset_deg for row in rows])
        self.inertia = np.array([row.inertia_kg_m2 or 0.0025 for row in rows])
        self.servo = np.array([row.servo_nm_rad or 4.0 for row in rows])
        self.cap = np.array([row.tau_max_nm for row in rows])
        joints = len(rows)
        self.q = self.sign * (np.full(joints, np.deg2rad(options.start_deg)) - self.offset)
        self.dq = np.zeros(joints)
        self.effort = np.zeros(joints)
        self.wanted = np.zeros(joints)
        self.goal = self.q.copy()
        self.powered = self.braking = self.asked = False
        self.fault = options.fault
        self.heard_s = 0.0
        self.looks = self.switched = 0
        self.told = False

    def reader(self, topic: str, kind: Any) -> Any:
        return DataReader(self.participant, Topic(self.participant, f"rt/{topic}", kind), qos=QOS)

    def writer(self, topic: str, kind: Any) -> Any:
        return DataWriter(self.participant, Topic(self.participant, f"rt/{topic}", kind), qos=QOS)

    def say(self, event: str) -> None:
        peak = float(np.rad2deg(np.abs(self.dq).max()))
        line = {"event": event, "t_s": time.monotonic(), "speed_deg_s": peak, "q_deg": self.angles()}
        sys.stdout.write(json.dumps(line) + "\n")
        sys.stdout.flush()

    def angles(self) -> list[float]:
        return [round(value, 4) for value in np.rad2deg(self.sign * self.q + self.offset).tolist()]

    def switch(self, on: bool, why: str) -> None:
        if on != self.powered:
            self.powered = on
            self.switched = self.looks
            self.braking = False
            self.wanted[:] = 0.0
            self.goal = self.q.copy()
            self.heard_s = time.monotonic()
            self.say(f"{'on' if on else 'off'} by {why}")

    def listen(self) -> None:
        for message in self.power.take(1):
            asked = getattr(message, "data", False)  # a notice that the app has gone holds none
            if asked and not self.asked:
                self.switch(True, "command")
            elif not asked and hasattr(message, "data"):
                self.switch(False, "command")
            self.asked = asked
        for message in self.clear.take(1):
            if getattr(message, "data", False):
                self.fault = ""
                self.faults.write(ros.String(""))
        for message in self.command.take(1):
            if hasattr(message, "data"):
                self.wanted = np.array(message.data)
            elif hasattr(message, "points"):
                self.goal = np.array(message.points[0].positions)
            else:
                continue
            self.heard_s = time.monotonic()
            self.braking = False
            self.check_power()

    def check_power(self) -> None:
        """Commands without power are a fault of the app; what was under way when it was cut is none."""
        if not (self.powered or self.told) and self.looks > self.switched + LOOKS_UNDER_WAY:
            self.told = True
            self.say("commanded without power")

    def watch(self) -> None:
        """The firmware's own watchdog: brakes when the commands stop, then cuts power."""
        silent_s = time.monotonic() - self.heard_s
        if self.powered and not self.braking and silent_s > self.options.watchdog_s:
            self.braking = True
            self.say("braked by watchdog")
        if self.braking and silent_s > self.options.watchdog_s + 0.3:
            self.switch(False, "watchdog")

    def step(self) -> None:
        damping = np.full(self.q.size, self.options.damping_nms_rad)
        torque = np.zeros(self.q.size)
        if self.powered and self.braking:
            damping += BRAKE_NMS_RAD
        elif self.powered and self.device.command == "effort":
            torque = self.wanted.copy()  # it trusts the app with its caps
        elif self.powered:
            damping += SERVO_DAMPING_NMS_RAD
            torque = np.clip(self.servo * (self.goal - self.q), -self.cap, self.cap)
        self.effort = torque
        share = STEP_S / self.inertia
        self.dq = (self.dq + share * torque) / (1.0 + share * damping)
        self.q = self.q + STEP_S * self.dq

    def publish(self) -> None:
        stamp = ros.Time(*divmod(time.time_ns(), 1_000_000_000))
        velocity = [] if self.options.no_velocity else self.dq.tolist()
        columns = (self.names, self.q.tolist(), velocity, self.effort.tolist())
        if self.options.vanish and self.looks > LOOKS_BEFORE_VANISHING:
            columns = (self.names[:1], *columns[1:])
        if not self.options.silent:
            self.state.write(ros.JointState(ros.Header(stamp, "hand"), *columns))
            if self.fault:
                self.faults.write(ros.String(self.fault))

    def run(self) -> None:
        self.say("ready")
        due_s = time.monotonic()
        every = max(round(self.device.period_ms / (1e3 * STEP_S * STEPS_A_LOOK)), 1)
        while True:
            if not self.options.deaf:
                self.listen()
                self.watch()
            for _ in range(STEPS_A_LOOK):
                self.step()
            if self.looks % every == 0:
                self.publish()
            self.looks += 1
            due_s += STEP_S * STEPS_A_LOOK
            time.sleep(max(due_s - time.monotonic(), 0.0))


if __name__ == "__main__":
    request_realtime_priority()
    StandIn(Options(**json.loads(sys.argv[1]))).run()
