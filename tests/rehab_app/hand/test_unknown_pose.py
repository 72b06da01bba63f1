"""A hand of which nothing is known says so in every field."""

from __future__ import annotations

import numpy as np

from rehab_app.hand.records import unknown_pose
from rehab_app.tracking.description import unknown
from sessions.records import Status


def test_an_unknown_hand_is_a_gap_everywhere() -> None:
    pose = unknown_pose(7)
    assert pose.t_ns == 7
    assert (pose.joint_status == Status.LOST).all()
    for values in (pose.p_camera_palm_m, pose.joints_rad, pose.fingertips_palm_m, pose.joint_covariance_rad2):
        assert np.isnan(values).all()


def test_a_tracker_says_the_same_of_its_markers() -> None:
    tracked = unknown(7, 3, "lost")
    assert (tracked.markers.status == Status.LOST).all()
    assert (tracked.pose.joint_status == Status.LOST).all()
    assert (tracked.detection == -1).all()
