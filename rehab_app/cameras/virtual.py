"""A camera without hardware: it renders a moving hand with paper markers, and knows the truth.

Simulated time: frame k is captured k periods after the start, however long the drawing takes. With
``realtime`` the camera waits for that instant before it hands the frame over, and skips captures (counting
them as dropped) when it has fallen behind by more than a few periods.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from types import TracebackType

import numpy as np

from rehab_app.cameras.frame import Frame
from rehab_app.cameras.levels import Level
from rehab_app.cameras.paper_markers import PlacedMarkers
from rehab_app.cameras.picture_trouble import PictureTrouble
from rehab_app.cameras.renderer import Renderer
from rehab_app.cameras.scene import HandScene, seen_from
from rehab_app.cameras.sensor import NoiseLevel
from rehab_app.geometry.pinhole import KINECT, Intrinsics
from rehab_app.geometry.view import PRIMARY, View
from sessions.errors import Refused
from sessions.records.fields import Float64

_LATE_PERIODS = 60  # two seconds at 30 Hz: what a camera's driver would buffer at best


@dataclass(frozen=True, slots=True)
class Truth:
    """What really was before the virtual camera at one instant.

    Attributes:
        t_s: Time since the start, s.
        joints_rad: Joint angles, shape (21,).
        p_camera_palm_m: Origin of the palm, shape (3,).
        rotation_camera_palm: Rotation from palm to camera, shape (3, 3).
        landmarks_camera_m: The 25 landmarks, shape (25, 3).
        markers: Centres and normals of the markers.
        pixel_px: Images of the centres, shape (M, 2).
        seen: Share of each disc that is in view, shape (M,); 0 is hidden.
    """

    t_s: float
    joints_rad: Float64
    p_camera_palm_m: Float64
    rotation_camera_palm: Float64
    landmarks_camera_m: Float64
    markers: PlacedMarkers
    pixel_px: Float64
    seen: Float64


class VirtualCamera:
    """Renders a ``HandScene``; same scene, noise and seed give the same frames, bit for bit."""

    name = "virtual-camera"
    has_depth = True

    def __init__(
        self,
        scene: HandScene,
        *,
        seed: int = 0,
        rate_hz: float = 30.0,
        realtime: bool = False,
        noise: NoiseLevel | None = None,
        intrinsics: Intrinsics = KINECT,
        start_ns: int = 0,
        level: Level | None = None,
        view: View = PRIMARY,
    ) -> None:
        """Set up the scene; nothing is drawn yet.

        Args:
            scene: Hand, markers and movement.
            seed: Of noise and background.
            rate_hz: Frames per second.
            realtime: Hand frames over at their time of capture on the monotonic clock.
            noise: What the sensor adds; by default that of a good RGB-D camera.
            intrinsics: The pinhole camera.
            start_ns: Time of the first capture in simulated time (in real time it is the clock's).
            level: What goes wrong in its pictures besides noise; nothing by default. Speed and depth of the
                movement are the scene's.
            view: Where it stands beside the camera in whose frame the scene is stated.

        Raises:
            Refused: The rate is not 1 to 240 Hz.
        """
        if not 1.0 <= rate_hz <= 240.0:
            raise Refused("frame rate", f"{rate_hz:g} Hz", "1 to 240 Hz", "choose a rate in that range")
        self.scene = scene
        self._rate_hz = rate_hz
        self._realtime = realtime
        self._intrinsics = intrinsics
        self._start_ns = start_ns
        self.view = view
        self._trouble = None if level is None else _trouble(scene, level, seed, intrinsics, rate_hz, view)
        self._renderer = Renderer(
            scene, noise or NoiseLevel(), intrinsics, seed, view=view, trouble=self._trouble
        )
        self._open = False

    @property
    def intrinsics(self) -> Intrinsics:
        """Camera of colour and depth."""
        return self._intrinsics

    @property
    def rate_hz(self) -> float:
        """Frames per second."""
        return self._rate_hz

    def __enter__(self) -> VirtualCamera:
        """Start the camera's clock."""
        if self._realtime:
            self._start_ns = time.monotonic_ns()
        self._open = True
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop."""
        self._open = False

    def frames(self) -> Iterator[Frame]:
        """Frames from the start on; after its last posture the hand holds still.

        Raises:
            Refused: The camera is not open.
        """
        if not self._open:
            raise Refused("camera", "closed", "open", "open it before asking for frames")
        index = 0
        while self._open:
            dropped = self._wait(index) + self._lost(index)
            index += dropped
            yield self.frame(index, dropped)
            index += 1

    def frame(self, index: int, dropped: int = 0) -> Frame:
        """The frame of one index."""
        colour, depth = self._renderer.render(index, index / self._rate_hz)
        return Frame(self.time_ns(index), colour, depth, self._intrinsics, dropped)

    def time_ns(self, index: int) -> int:
        """Capture time of a frame, monotonic, ns."""
        return self._start_ns + round(index * 1e9 / self._rate_hz)

    def truth(self, t_s: float) -> Truth:
        """What is before the camera ``t_s`` seconds after the start, in its own frame.

        A marker that a level takes out of the frame of that instant has nothing in view.
        """
        posed = self._renderer.at(t_s)
        return Truth(
            t_s,
            posed.joints_rad,
            posed.p_camera_palm_m,
            posed.rotation_camera_palm,
            posed.landmarks_camera_m,
            posed.markers,
            self._intrinsics.project(posed.markers.p_camera_m),
            self._renderer.seen(posed, round(t_s * self._rate_hz)),
        )

    def truth_joints_rad(self, t_s: Float64) -> Float64:
        """True joint angles at times (N,), shape (N, 21)."""
        return self.scene.motion.joints_at(np.asarray(t_s, np.float64))

    def _lost(self, index: int) -> int:
        """How many captures from ``index`` on never come."""
        count = 0
        while self._trouble is not None and self._trouble.dropped(index + count):
            count += 1
        return count

    def _wait(self, index: int) -> int:
        """Wait for a frame's time; the number of captures to skip when far behind."""
        if not self._realtime:
            return 0
        ahead_s = (self.time_ns(index) - time.monotonic_ns()) * 1e-9
        if ahead_s > 0.0:
            time.sleep(ahead_s)
            return 0
        late = int(-ahead_s * self._rate_hz)
        return late if late >= _LATE_PERIODS else 0


def _trouble(
    scene: HandScene, level: Level, seed: int, intrinsics: Intrinsics, rate_hz: float, view: View
) -> PictureTrouble:
    """A level's troubles about the open hand, other ones for each camera."""
    points = seen_from(scene.at(0.0), view).markers.p_camera_m
    return PictureTrouble(
        level,
        seed * 64 + view.index,
        intrinsics,
        rate_hz,
        intrinsics.project(points),
        float(points[:, 2].mean()),
    )
