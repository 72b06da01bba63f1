"""Which cameras there are: what ``rehab-app camera list`` and the recording page show."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from rehab_app.cameras import drivers
from rehab_app.cameras.lease import CameraLease
from rehab_app.cameras.webcam import webcam_indices

State = Literal["ready", "busy", "unavailable"]
VIRTUAL = "virtual"
_KINDS = {
    "realsense": "Intel RealSense",
    "kinect": "Kinect (first generation)",
    "openni": "OpenNI camera (Xtion, PrimeSense)",
}
_NO_WEBCAMS = ("RealSense", "Kinect")  # the system lists their colour streams as webcams, too


@dataclass(frozen=True, slots=True)
class CameraListing:
    """One camera that could be recorded from.

    Attributes:
        id: What ``open_camera`` takes, such as ``webcam:0``.
        label: What a person calls it.
        state: ``ready``; ``busy`` while it is being recorded from; ``unavailable`` without its driver.
        has_depth: Whether it sees depth.
        remedy: What to do where it is not ready, as one sentence; empty where it is.
    """

    id: str
    label: str
    state: State
    has_depth: bool
    remedy: str = ""


def list_cameras() -> tuple[CameraListing, ...]:
    """The cameras of this machine, without opening any; kinds whose driver is missing say what they need.

    Videos and recorded sessions are cameras too, but are named by their file: see ``open_camera``.
    """
    return (
        CameraListing(VIRTUAL, "Virtual camera", "ready", True),
        *(one for found in drivers.look_apart() for one in _depth_cameras(found)),
        *_webcams(),
    )


def _depth_cameras(found: drivers.Found) -> Iterator[CameraListing]:
    if found.remedy:
        yield CameraListing(found.kind, _KINDS[found.kind], "unavailable", True, found.remedy)
    for name, label in found.cameras:
        yield _listed(name, label, has_depth=True)


def _webcams() -> Iterator[CameraListing]:
    for index in webcam_indices():
        named = Path(f"/sys/class/video4linux/video{index}/name")
        name = named.read_text(errors="replace").strip() if named.is_file() else f"Webcam {index}"
        if not any(maker in name for maker in _NO_WEBCAMS):
            yield _listed(f"webcam:{index}", name, has_depth=False)


def _listed(camera: str, label: str, *, has_depth: bool) -> CameraListing:
    kind = camera.partition(":")[0]  # by which the first RealSense can be taken, too
    if CameraLease(camera).is_taken or CameraLease(kind).is_taken:
        remedy = "End the other recording first."
        return CameraListing(camera, label, "busy", has_depth, remedy)
    return CameraListing(camera, label, "ready", has_depth)
