"""What was seen in one image: blobs with a place in space and its uncertainty, but no name yet."""

from __future__ import annotations

from dataclasses import dataclass

from sessions.records.fields import Float64


@dataclass(frozen=True, slots=True)
class Detections:
    """The marker candidates of one capture, in no particular order.

    Attributes:
        t_capture_ns: Capture time, monotonic, ns.
        pixel_px: Sub-pixel centres u v, shape (D, 2).
        p_camera_m: Points in the camera frame, shape (D, 3).
        covariance_m2: Covariance of each point, shape (D, 3, 3).
        similarity: Likeness to the marker model, 0 to 1, shape (D,).
    """

    t_capture_ns: int
    pixel_px: Float64
    p_camera_m: Float64
    covariance_m2: Float64
    similarity: Float64

    def __len__(self) -> int:
        """Number of detections."""
        return len(self.pixel_px)
