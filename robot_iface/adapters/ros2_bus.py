"""Topics of one device over DDS: what comes in, what goes out, who else is there. Nothing here waits.

Needs the ``ros2`` extra. Every failure of the middleware is an ``OSError``, as of any other device.
"""

from __future__ import annotations

import errno
import struct
from collections.abc import Generator
from contextlib import contextmanager
from typing import Any, TypeVar
from xml.sax.saxutils import quoteattr

from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication
from cyclonedds.core import DDSException, Entity
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.internal import InvalidSample
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

from robot_iface.adapters import ros2_messages as ros
from robot_iface.adapters.device_file import Device, Network

T = TypeVar("T", bound=IdlStruct)
_NOW = ros.Header(ros.Time(0, 0), "")
_PLAIN_CDR = Policy.DataRepresentation(use_cdrv0_representation=True)
_NEWEST = Policy.History.KeepLast(1)
_IN = Qos(Policy.Reliability.BestEffort, _NEWEST, _PLAIN_CDR)
_OUT = Qos(Policy.Reliability.Reliable(max_blocking_time=0), _NEWEST, _PLAIN_CDR)
_MOST_WRITERS = 1000
_LEASE_S = 2
"""After this silence a participant counts as gone: what a killed app has left behind is soon forgotten."""


class Bus:
    """The topics of one device, from the app's side.

    Args:
        device: The device file.

    Raises:
        OSError: The network interface or the DDS domain cannot be used.
    """

    def __init__(self, device: Device) -> None:
        self._names = [joint.ros for joint in device.joint]
        topics = device.topics
        effort = device.command == "effort"
        with _as_os_error():
            self._domain = Domain(device.network.domain, dds_configuration(device.network))
            self._participant = DomainParticipant(device.network.domain)
            self._state = self._reader(topics.state, ros.JointState)
            self._faults = self._reader(topics.faults, ros.String)
            self._command = self._writer(
                topics.command, ros.Float64MultiArray if effort else ros.JointTrajectory
            )
            self._power = self._writer(topics.power, ros.Bool)
            self._clear = self._writer(topics.clear, ros.Bool)
            self._writers = BuiltinDataReader(self._participant, BuiltinTopicDcpsPublication)
        seconds, nanoseconds = divmod(device.period_ns, 1_000_000_000)
        self._period = ros.Duration(seconds, nanoseconds)
        self._layout = ros.MultiArrayLayout([], 0)

    def take_state(self) -> ros.JointState | None:
        """The newest joint state that has not been taken yet."""
        with _as_os_error():
            return _newest(self._state.take(1))

    def take_faults(self) -> str | None:
        """The newest fault text that has not been taken yet: names apart by commas, empty when healthy."""
        with _as_os_error():
            text = _newest(self._faults.take(1))
        return None if text is None else text.data

    def send_efforts(self, efforts_nm: list[float]) -> None:
        """Command efforts, in the driver's order and signs."""
        self._send(self._command, ros.Float64MultiArray(self._layout, efforts_nm))

    def send_point(self, positions_rad: list[float], velocities_rad_s: list[float]) -> None:
        """Command where to be one period from now, in the driver's order and signs."""
        point = ros.JointTrajectoryPoint(positions_rad, velocities_rad_s, [], [], self._period)
        self._send(self._command, ros.JointTrajectory(_NOW, self._names, [point]))

    def send_power(self, powered: bool) -> None:
        """Power the motors, or cut their power."""
        self._send(self._power, ros.Bool(powered))

    def send_clear(self) -> None:
        """Clear the driver's faults."""
        self._send(self._clear, ros.Bool(True))

    def heard(self) -> bool:
        """Whether the device listens to commands and to power."""
        with _as_os_error():
            return all(writer.get_matched_subscriptions() for writer in (self._command, self._power))

    def rivals(self) -> int:
        """How many others write commands for this device."""
        with _as_os_error():
            found: Any = self._writers.read(_MOST_WRITERS)
            mine = self._participant.guid
        theirs = [
            writer
            for writer in found
            if getattr(writer, "topic_name", "") == self._command.topic.name
            and writer.participant_key != mine
        ]
        return len(theirs)

    def close(self) -> None:
        """Leave the network; what is sent afterwards fails."""
        parts: tuple[Entity, ...] = (self._participant, self._domain)
        for part in parts:  # now, not when the last reference goes: there is no other way to delete an entity
            part.__del__()

    def _reader(self, topic: str, kind: type[T]) -> DataReader[T]:
        return DataReader(self._participant, Topic(self._participant, f"rt/{topic}", kind), qos=_IN)

    def _writer(self, topic: str, kind: type[T]) -> DataWriter[T]:
        return DataWriter(self._participant, Topic(self._participant, f"rt/{topic}", kind), qos=_OUT)

    @staticmethod
    def _send(writer: DataWriter[T], message: T) -> None:
        with _as_os_error():
            writer.write(message)


def dds_configuration(network: Network) -> str:
    """Cyclone DDS configuration of a network, XML: without multicast where peers are named or on loopback."""
    loopback = network.interface == "lo"
    peers = network.peers or (("127.0.0.1",) if loopback else ())
    interface = f"<NetworkInterface name={quoteattr(network.interface)}/>" if network.interface else ""
    interfaces = f"<Interfaces>{interface}</Interfaces>" if interface else ""
    multicast = "<AllowMulticast>false</AllowMulticast>" if peers else ""
    known = "".join(f"<Peer Address={quoteattr(peer)}/>" for peer in peers)
    return (
        f'<CycloneDDS><Domain Id="{network.domain}"><General>{interfaces}{multicast}</General>'
        f"<Discovery><LeaseDuration>{_LEASE_S}s</LeaseDuration><ParticipantIndex>auto</ParticipantIndex>"
        f"<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex><Peers>{known}</Peers></Discovery>"
        "</Domain></CycloneDDS>"
    )


def _newest(samples: list[T]) -> T | None:
    """The sample that was taken; a notice that a writer has gone is none."""
    return samples[0] if samples and not isinstance(samples[0], InvalidSample) else None


@contextmanager
def _as_os_error() -> Generator[None, None, None]:
    try:
        yield
    except DDSException as error:
        raise OSError(errno.EIO, f"DDS: {error.msg}") from error
    except (ValueError, IndexError, struct.error) as error:  # bytes that are not of the declared type
        raise OSError(errno.EPROTO, f"unreadable message ({error})") from error
