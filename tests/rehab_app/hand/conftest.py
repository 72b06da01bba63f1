"""A known person wearing markers, before a camera: what the fits are measured against."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rehab_app.hand.marker_model import MarkerModel
from rehab_app.hand.protocol import MarkerProtocol, load_protocol
from rehab_app.hand.series import LandmarkSeries
from rehab_app.hand.subject import Subject, average_subject
from robot_iface.kinematics import JOINT_MAX_RAD, JOINT_MIN_RAD, couple_dip
from sessions.records import JOINTS, Side
from sessions.records.fields import Float64

PIP = [JOINTS.index(f"{finger}_pip") for finger in ("index", "middle", "ring", "little")]


@dataclass(frozen=True)
class Scene:
    """Truth: joints (N, 21), palm pose, markers without noise (N, M, 3)."""

    protocol: MarkerProtocol
    subject: Subject
    joints_rad: Float64
    rotation: Float64
    p_palm_m: Float64
    p_camera_m: Float64

    def series(self, noise_m: float, rng: np.random.Generator, rate_hz: float = 30.0) -> LandmarkSeries:
        seen = self.p_camera_m + noise_m * rng.standard_normal(self.p_camera_m.shape)
        return LandmarkSeries(np.arange(len(seen)) / rate_hz, self.protocol.names, seen)


def random_joints(frames: int, rng: np.random.Generator) -> Float64:
    """Angles inside the anatomical range, tips roughly coupled."""
    low, high = 0.9 * JOINT_MIN_RAD, 0.9 * JOINT_MAX_RAD
    joints = couple_dip(rng.uniform(low, high, (frames, 21)))
    dips = np.array(PIP) + 1
    joints[:, dips] += 0.15 * rng.standard_normal((frames, 4))
    return np.clip(joints, low, high)


def scene(name: str, side: Side, joints_rad: Float64, seed: int, subject: Subject | None = None) -> Scene:
    rng = np.random.default_rng(seed)
    protocol = load_protocol(name)
    worn = average_subject(protocol, side) if subject is None else subject
    frames = len(joints_rad)
    rotation = Rotation.random(frames, random_state=seed).as_matrix()
    p_palm = rng.normal((0.0, 0.0, 0.7), 0.1, (frames, 3))
    local = MarkerModel(worn, protocol).positions(joints_rad)
    p_camera = np.einsum("nij,nmj->nmi", rotation, local) + p_palm[:, None]
    return Scene(protocol, worn, joints_rad, rotation, p_palm, p_camera)


def person(name: str, side: Side, length_m: float, seed: int) -> Subject:
    """Somebody whose bones and marker places differ from the average."""
    rng = np.random.default_rng(seed)
    protocol = load_protocol(name)
    average = average_subject(protocol, side, length_m)
    bones = average.geometry.bones_m * np.exp(0.05 * rng.standard_normal((5, 3)))
    offsets = average.marker_offset_m + 0.5 * protocol.offset_stds_m * rng.standard_normal(
        (len(protocol.markers), 3)
    )
    return Subject(replace(average.geometry, bones_m=bones), protocol.names, offsets)


@pytest.fixture(name="scene")
def _scene() -> Callable[..., Scene]:
    return scene


@pytest.fixture(name="person")
def _person() -> Callable[..., Subject]:
    return person


@pytest.fixture(name="random_joints")
def _random_joints() -> Callable[..., Float64]:
    return random_joints
