"""Approvals that are taken back, and what a take's page says of how it was seen."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import numpy as np
import pytest

from rehab_app.access import CONSOLE, Account
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import Refused
from rehab_app.services.take_chart import joint_chart
from rehab_app.services.take_quality import quality_of
from robot_iface.build import DEVICES
from robot_iface.types import JOINTS
from sessions.records import Status

ASSISTANT = Account("sam", "assistant", "2")
AUDITOR = Account("kim", "auditor", "3")


@pytest.fixture(scope="module")
def clinic(tmp_path_factory, take_file):
    with open_clinic(tmp_path_factory.mktemp("approvals")) as opened:
        opened.takes.get(take_file)
        yield opened


@pytest.fixture
def take(clinic):
    row = clinic.takes.list()[0]
    clinic.takes.approve(row.id, CONSOLE)
    return row.id


@pytest.fixture(scope="module")
def motion(clinic):
    return clinic.takes.motion(clinic.takes.list()[0].id)


def test_a_withdrawn_take_cannot_be_played(clinic, take):
    clinic.therapy.check_approved(clinic.takes.get(take))
    assert clinic.takes.list()[0].approved_by == "console"
    clinic.approvals.withdraw(take, ASSISTANT, "too fast")
    assert clinic.takes.list()[0].approved_by is None
    assert clinic.takes.get(take).approved_by is None
    assert clinic.takes.approval(take) is None
    with pytest.raises(Refused, match="not approved"):
        clinic.therapy.check_approved(clinic.takes.get(take))
    said = clinic.approvals.withdrawal(take)
    assert (said.by, said.reason) == ("sam", "too fast")
    assert said.utc_ns > 0


def test_a_newer_approval_holds_again(clinic, take):
    clinic.approvals.withdraw(take, ASSISTANT, "too fast")
    clinic.takes.approve(take, CONSOLE)
    assert clinic.takes.get(take).approved_by == "console"
    assert clinic.approvals.withdrawal(take) is None


def test_withdrawing_needs_a_reason_a_role_and_an_approval(clinic, take):
    with pytest.raises(Refused, match="empty"):
        clinic.approvals.withdraw(take, ASSISTANT, "  ")
    with pytest.raises(Refused, match="at most 500"):
        clinic.approvals.withdraw(take, ASSISTANT, "x" * 501)
    with pytest.raises(Refused, match="may not note"):
        clinic.approvals.withdraw(take, AUDITOR, "why")
    assert clinic.takes.get(take).approved_by == "console"
    clinic.approvals.withdraw(take, ASSISTANT, "why")
    with pytest.raises(Refused, match="not approved"):
        clinic.approvals.withdraw(take, ASSISTANT, "again")
    with pytest.raises(Refused):
        clinic.approvals.withdraw("ffffffff", ASSISTANT, "why")


def test_withdrawing_is_in_the_audit(clinic, take):
    clinic.approvals.withdraw(take, ASSISTANT, "private words")
    row = next(one for one in clinic.catalogue.audit() if one.verb == "withdraw approval")
    assert (row.actor, row.subject) == ("sam", take)
    assert "private" not in row.detail


def test_quality_counts_what_was_seen(motion):
    whole = quality_of(motion)
    assert whole.measured + whole.estimated + whole.lost == pytest.approx(1.0)
    assert whole.frames == len(motion.t_s)
    assert whole.rate_hz == pytest.approx(30.0, rel=0.02)
    status = np.full_like(motion.joint_status, Status.MEASURED)
    clean = replace(motion, joint_status=status, residual_m=np.full(len(motion.t_s), 0.001))
    assert quality_of(clean).verdict == "good"
    assert quality_of(clean).longest_gap_s == 0.0
    status = status.copy()
    status[10:40, 5] = Status.LOST
    gap_s = float(motion.t_s[40] - motion.t_s[9])
    assert quality_of(replace(clean, joint_status=status)).longest_gap_s == pytest.approx(gap_s)
    assert quality_of(replace(clean, joint_status=np.zeros_like(status))).verdict == "poor"
    assert quality_of(replace(clean, residual_m=np.full(len(motion.t_s), 0.01))).verdict == "usable"


def test_joints_that_move_are_named_with_their_range(motion):
    moving = {name: (low, high) for name, low, high in quality_of(motion).moving}
    low, high = moving["index_pip"]
    assert np.rad2deg(high - low) == pytest.approx(35.0, abs=6.0)
    still = motion.joints_rad.copy()
    still[:, JOINTS.index("index_pip")] = 0.3
    assert "index_pip" not in dict.fromkeys(
        name for name, _, _ in quality_of(replace(motion, joints_rad=still)).moving
    )


def test_the_chart_draws_fifteen_joints_and_leaves_gaps(motion):
    def curves(svg):
        root = ElementTree.fromstring(svg)
        return [node for node in root.iter() if node.attrib.get("stroke-width") == "2"]

    assert len(curves(joint_chart(motion))) == 15
    both = curves(joint_chart(motion, motion))
    assert len([one for one in both if "stroke-dasharray" in one.attrib]) == 15
    joints = motion.joints_rad.copy()
    joints[20:30, JOINTS.index("index_pip")] = np.nan
    joints[:, JOINTS.index("little_dip")] = np.nan
    gappy = joint_chart(replace(motion, joints_rad=joints))
    assert len(curves(gappy)) == 15
    assert "nan" not in gappy


def test_devices_are_looked_at_and_none_is_opened(clinic):
    assert [one.name for one in clinic.devices.robots()][: len(DEVICES)] == list(DEVICES)
    assert all(one.capabilities is not None and one.last_fit is None for one in clinic.devices.robots()[:2])
    cameras = clinic.devices.cameras()
    assert (cameras[0].listing.id, cameras[0].calibration) == ("virtual", None)
    assert clinic.devices.board("pdf").startswith(b"%PDF")
    assert b"<svg" in clinic.devices.board("svg")
    with pytest.raises(Refused, match="board file"):
        clinic.devices.board("exe")
