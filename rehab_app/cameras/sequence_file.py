"""Writes a point sequence as the detections file that ``rehab-app track`` reads."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from rehab_app.cameras.sequence import PointSequence


def write_detections_npz(sequence: PointSequence, path: Path) -> None:
    """Write the detections of the tracking camera with names for the markers of frame 0.

    Dropped frames stand in ``frame_t_s`` without detections, so that rows count captures. The truth is not
    written. The file appears whole or not at all.

    Args:
        sequence: What to write.
        path: The ``.npz`` to make.
    """
    first = [np.flatnonzero(one.view == sequence.views[0].index) for one in sequence.detections]
    counts = [len(rows) for rows in first]
    pixel = np.concatenate([d.pixel_px[rows] for d, rows in zip(sequence.detections, first, strict=True)])
    turn = sequence.views[0].rotation_tracking_camera
    origin = sequence.views[0].p_tracking_camera_m
    points = np.concatenate([d.p_camera_m[rows] for d, rows in zip(sequence.detections, first, strict=True)])
    camera = sequence.intrinsics
    partial = path.with_name(path.name + ".partial")
    with partial.open("wb") as file:
        np.savez_compressed(
            file,
            frame_t_s=1e-9 * sequence.t_ns,
            frame=np.repeat(np.arange(len(counts)), counts),
            u_px=pixel[:, 0],
            v_px=pixel[:, 1],
            depth_m=((points - origin) @ turn)[:, 2],
            init_name=np.array(sequence.protocol.names),
            init_u_px=sequence.init_pixel_px[:, 0],
            init_v_px=sequence.init_pixel_px[:, 1],
            fx=camera.fx_px,
            fy=camera.fy_px,
            cx=camera.cx_px,
            cy=camera.cy_px,
            width=camera.width_px,
            height=camera.height_px,
        )
    os.replace(partial, path)
