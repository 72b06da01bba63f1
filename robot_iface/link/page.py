"""One page of memory that app and motion process share: stop word, heartbeat, live telemetry.

It is an anonymous memory file handed on by descriptor, so that nothing with a name can be left behind or be
opened by somebody else. Each word is eight aligned bytes, written and read whole; telemetry stands under a
sequence lock (odd while it is being written), so that no reader ever makes the control loop wait.
"""

from __future__ import annotations

import mmap
import os
import struct
import time

import numpy as np

from robot_iface.runtime import PHASES, STARTERS, LiveSample
from robot_iface.types import SafetyState

MAX_JOINTS = 32
PAGE_BYTES = 4096
_READ_TRIES = 1000

_STOP, _PRESSED_NS, _BEAT_NS, _OPERATOR_NS, _LATCHED_NS, _SEQUENCE = range(6)
_TELEMETRY_OFFSET = 64
_HEAD = struct.Struct("<qddqqqqqqq")
"""t, path_s, path_speed, repetition, phase, starter, state, joints, lateness, overruns."""


class SharedPage:
    """The shared page, from either side.

    Args:
        descriptor: File descriptor of the page, owned from now on; by default a new page is made.
    """

    def __init__(self, descriptor: int | None = None) -> None:
        if descriptor is None:
            descriptor = os.memfd_create("rehab-motion", os.MFD_CLOEXEC)
            os.ftruncate(descriptor, PAGE_BYTES)
        self.descriptor = descriptor
        self._map = mmap.mmap(descriptor, PAGE_BYTES)
        self._bytes = memoryview(self._map)
        self._words = self._bytes.cast("q")
        self._newest = bytes(_HEAD.size)

    def press_stop(self) -> None:
        """Write the stop word; the first press keeps its time. Takes no lock and makes no system call."""
        if not self._words[_STOP]:
            self._words[_PRESSED_NS] = time.monotonic_ns()
        self._words[_STOP] = 1

    def pressed(self) -> bool:
        """Whether somebody has pressed stop since it was last cleared."""
        return self._words[_STOP] != 0

    def clear_stop(self) -> None:
        """Take the stop word back."""
        self._words[_STOP] = 0
        self._words[_LATCHED_NS] = 0

    @property
    def pressed_t_ns(self) -> int:
        """Monotonic time of the newest first press, 0 if there was none."""
        return self._words[_PRESSED_NS]

    @property
    def latched_t_ns(self) -> int:
        """Monotonic time at which the loop acted on the stop word, 0 if it has not."""
        return self._words[_LATCHED_NS]

    def latch(self) -> None:
        """Note, once, that the loop has acted on the stop word."""
        if not self._words[_LATCHED_NS]:
            self._words[_LATCHED_NS] = time.monotonic_ns()

    def beat(self) -> None:
        """Show the motion process that the app is alive."""
        self._words[_BEAT_NS] = time.monotonic_ns()

    def beat_age_ns(self) -> int:
        """Time since the newest beat."""
        return time.monotonic_ns() - self._words[_BEAT_NS]

    def operator_beat(self) -> None:
        """Show the motion process that the operator's page is alive and its picture fresh."""
        self._words[_OPERATOR_NS] = time.monotonic_ns()

    def operator_age_ns(self) -> int:
        """Time since the operator's newest beat; 0 where none watches."""
        newest = self._words[_OPERATOR_NS]
        return time.monotonic_ns() - newest if newest else 0

    def forget_operator(self) -> None:
        """No operator watches, until the next beat."""
        self._words[_OPERATOR_NS] = 0

    def write_live(self, sample: LiveSample) -> None:
        """Publish telemetry; only the motion process does."""
        head = _HEAD.pack(
            *(sample.t_ns, sample.path_s, sample.path_speed, sample.repetition),
            *(PHASES.index(sample.phase), STARTERS.index(sample.started_by), int(sample.safety_state)),
            *(sample.q_rad.size, sample.late_p99_ns, sample.overruns),
        )
        rows = (sample.q_rad, sample.q_reference_rad, sample.tau_interaction_nm, sample.stiffness_multiple)
        body = np.concatenate(rows).tobytes()
        self._words[_SEQUENCE] += 1
        end = _TELEMETRY_OFFSET + len(head)
        self._bytes[_TELEMETRY_OFFSET:end] = head
        self._bytes[end : end + len(body)] = body
        self._words[_SEQUENCE] += 1

    def read_live(self) -> LiveSample:
        """The newest telemetry, whole; the one before it if the writer died or was halted while writing."""
        for _ in range(_READ_TRIES):
            before = self._words[_SEQUENCE]
            content = bytes(self._bytes[_TELEMETRY_OFFSET : _TELEMETRY_OFFSET + _HEAD.size + 32 * MAX_JOINTS])
            if before % 2 == 0 and before == self._words[_SEQUENCE]:
                self._newest = content
                break
        return self._sample(self._newest)

    def _sample(self, content: bytes) -> LiveSample:
        head = _HEAD.unpack_from(content)
        t_ns, path_s, path_speed, repetition, phase, starter, state, joints, late_p99_ns, overruns = head
        rows = np.frombuffer(content, np.float64, 4 * joints, _HEAD.size).reshape(4, joints)
        return LiveSample(
            t_ns=t_ns,
            q_rad=rows[0],
            q_reference_rad=rows[1],
            tau_interaction_nm=rows[2],
            path_s=path_s,
            path_speed=path_speed,
            repetition=repetition,
            phase=PHASES[phase],
            started_by=STARTERS[starter],
            safety_state=SafetyState(state),
            stiffness_multiple=rows[3],
            stop_latched_t_ns=self.latched_t_ns,
            late_p99_ns=late_p99_ns,
            overruns=overruns,
        )

    def close(self) -> None:
        """Close the descriptor; the memory stays until nobody holds it, so that a late press does no harm."""
        os.close(self.descriptor)
