"""Records a run of the motion process as a session file.

What flows::

    motion process ──TickBlock, PhaseChange, SafetyEvent──▶ RunRecorder ──records──▶ SessionWriter
                   ──RunEnd────────────────────────────────▶ seal ──▶ measure ──▶ PlayResult
"""

from __future__ import annotations

import uuid
from collections.abc import Iterable, Iterator
from pathlib import Path

import msgspec

from rehab_app.grasp.target_json import with_target
from rehab_app.hand.subject import geometry_to_json
from rehab_app.therapy.run_poses import run_hand
from rehab_app.therapy.run_recorder import Message, RunRecorder
from rehab_app.therapy.run_result import PlayResult, result_of
from robot_iface.errors import Refused
from robot_iface.kinematics import HandGeometry
from robot_iface.types import Capabilities, Certificate, Limits, Plan, RunEnd
from sessions.records import SessionHeader
from sessions.store import SessionWriter
from sessions.timebase import Timebase

__all__ = ["PlayResult", "record_run", "session_header"]


def session_header(
    plan: Plan,
    certificate: Certificate,
    geometry: HandGeometry,
    exercise: str,
    subject_id: str,
    device: Capabilities,
    take_prescription: str = "",
) -> SessionHeader:
    """Header of a therapy session.

    A simulated device keeps simulated time, which starts at 0 and is the monotonic clock of the file, so that
    equal runs write equal messages; a real device keeps the machine's.

    Args:
        plan: What is played.
        certificate: Of its rehearsal.
        geometry: The patient's hand.
        exercise: Exercise name; empty for that of a guided sweep.
        subject_id: Pseudonym.
        device: What plays it.
        take_prescription: That of the take's header: a computed grasp names its target there.
    """
    now = Timebase.now()
    return SessionHeader(
        session_id=uuid.uuid4().hex,
        kind="therapy",
        subject_id=subject_id,
        side=plan.side,
        exercise=exercise or _untitled(plan),
        source=source_of(plan, device),
        software_version=plan.software_version,
        utc_start_ns=now.utc_start_ns,
        monotonic_start_ns=0 if device.simulated else now.monotonic_start_ns,
        robot_joints=plan.joint_names,
        subject_hand=geometry_to_json(geometry),
        limits=limits_of_header(plan.limits, device),
        prescription=with_target(_json(plan.prescription), take_prescription),
        certificate=_json(certificate),
        parents=() if plan.path is None else (plan.path.take_digest,),
    )


def limits_of_header(limits: Limits, device: Capabilities) -> str:
    """The limits that held and the device's own range beside them, as JSON.

    A joint that was moved to ``device_min_rad`` or ``device_max_rad`` met the end of the device, not that of
    the patient: whoever reads the file can say so (hazard 15) without knowing the device.

    Args:
        limits: What held.
        device: What played it.
    """
    held: dict[str, object] = msgspec.json.decode(_json(limits))
    own = {"device_min_rad": device.q_min_rad.tolist(), "device_max_rad": device.q_max_rad.tolist()}
    return _json({**held, **own})


def source_of(plan: Plan, device: Capabilities) -> str:
    """What moved, in words: device, whether it is simulated and with whom, whose chain its joints follow."""
    facts: list[str] = []
    if device.simulated:
        facts.append(f"simulated, {plan.twin.kind}" if device.worn else "simulated")
    if device.chain != "hand":
        facts.append(f"not worn, its own {device.chain} chain")
    return f"{device.name} ({', '.join(facts)})" if facts else device.name


def _untitled(plan: Plan) -> str:
    if plan.sweep is None:
        return ""
    return {"fit": "fit check", "tone": "tone test"}.get(plan.sweep.kind, "range sweep")


def record_run(
    messages: Iterable[Message | RunEnd],
    path: Path,
    header: SessionHeader,
    plan: Plan,
    geometry: HandGeometry,
    device: Capabilities,
) -> PlayResult:
    """Write everything that the motion process reports until it ends, seal the file and measure it.

    A run that was stopped ends, too, and is sealed like any other. Leaving by an exception leaves the
    ``.partial.mcap``, which ``recover`` restores.

    Args:
        messages: What ``MotionClient.messages`` yields; a RunEnd comes last.
        path: The session file.
        header: Its header.
        plan: What is played.
        geometry: The patient's hand.
        device: What plays it.

    Raises:
        Refused: The motion process ended without saying how, or the file cannot be written.
    """
    hand = run_hand(device, geometry)
    end: RunEnd | None = None
    with SessionWriter(path, header) as writer:
        recorder = RunRecorder(
            writer.write, hand, plan.joint_names, plan.prescription.mode, follows=plan.path is not None
        )
        for message in _until_lost(messages, writer.partial):
            if isinstance(message, RunEnd):
                end = message
                break
            recorder.take(message)
        if end is None:
            raise Refused("motion process", "gone before the run ended", *_restore(writer.partial))
        sealed = writer.seal()
    return result_of(sealed, plan.prescription.mode, end, worn=device.worn)


def _until_lost(messages: Iterable[Message | RunEnd], partial: Path) -> Iterator[Message | RunEnd]:
    """The messages; where the motion process is lost among them, the refusal says how to get the file back.

    Raises:
        Refused: The motion process failed.
    """
    try:
        yield from messages
    except Refused as lost:
        raise Refused(lost.thing, lost.value, *_restore(partial)) from lost


def _restore(partial: Path) -> tuple[str, str]:
    """What should have been, and what to do about a session file that was not sealed."""
    return (
        "running to the end of the run",
        f"look at the patient, get what was recorded back with rehab-app recover {partial}, then play again",
    )


def _json(value: object) -> str:
    """JSON of a frozen dataclass; arrays become lists."""
    return msgspec.json.encode(value, enc_hook=_plain).decode()


def _plain(value: object) -> object:
    """Arrays and scalars as lists and numbers."""
    listed = getattr(value, "tolist", None)
    if listed is None:
        raise NotImplementedError(f"{type(value).__name__} has no JSON form")
    return listed()
