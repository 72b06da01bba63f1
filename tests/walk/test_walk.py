"""One datum from camera to report: a known flexion of the index PIP joint, through the whole house."""

from __future__ import annotations

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from rehab_app.cli.app import app

TRUTH_DEG = 40.0


def run(data, *arguments):
    result = CliRunner().invoke(app, [*(str(item) for item in arguments), "--data", str(data), "--json"])
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


def metric(report, name, subject):
    return next(item for item in report["metrics"] if (item["name"], item["subject"]) == (name, subject))


@pytest.fixture(scope="module")
def walked(tmp_path_factory):
    """Every step through the real command line, each by the file that the one before it named."""
    data = tmp_path_factory.mktemp("clinic")
    take = run(
        data, "record", "--exercise", "index_pip", "--side", "right", "--seconds", "5.5", "--seed", "11"
    )
    of_take = run(data, "report", take["take"])
    approval = run(data, "approve", take["take"], "--by", "anna")
    rehearsal = run(data, "rehearse", take["id"], "--repetitions", "1")
    played = run(
        data, "play", take["id"], "--mode", "passive", "--virtual-patient", "healthy", "--repetitions", "1"
    )
    of_session = run(data, "report", played["session"])
    return {
        "data": data,
        "take": take,
        "of_take": of_take,
        "approval": approval,
        "rehearsal": rehearsal,
        "played": played,
        "of_session": of_session,
    }


def test_the_report_of_the_take_says_40_degrees_with_its_lineage(walked):
    range_ = metric(walked["of_take"], "range_of_motion", "index_pip")
    assert range_["unit"] == "rad"
    assert range_["status"].split(":")[0] in ("ok", "flagged")
    assert np.rad2deg(range_["value"]) == pytest.approx(TRUTH_DEG, abs=2.0)
    low, high = range_["interval"]
    assert low < range_["value"] < high
    lineage = range_["lineage"]
    assert lineage["file_sha256"] == walked["approval"]["sha256"]
    assert "/hand/pose" in lineage["topics"]
    assert lineage["source"] == "virtual-camera"


def test_joints_that_were_held_still_report_little_motion(walked):
    for joint in ("middle_pip", "ring_pip", "index_mcp_flexion"):
        range_ = metric(walked["of_take"], "range_of_motion", joint)
        assert np.rad2deg(range_["value"]) < 4.0, joint


def test_the_rehearsal_attests_what_is_played(walked):
    assert walked["rehearsal"]["accepted"]
    assert max(walked["rehearsal"]["peak_interaction_nm"].values()) < 0.25
    assert max(walked["rehearsal"]["budget_m"].values()) < 0.03


def test_the_robot_follows_to_the_end(walked):
    played = walked["played"]
    assert played["completed"]
    assert played["stops"] == []
    assert [item["index"] for item in played["repetitions"]] == [0]
    assert 0.0 < np.rad2deg(played["rmse_rad"]) < 4.0
    assert 0.0 < played["fingertip_rmse_m"] < 0.008


def test_the_report_of_the_session_says_the_same_movement_by_its_encoder(walked):
    """Passive on a healthy hand at 3 times the thesis gains, stiffness loses less than 4 of 40 degrees."""
    range_ = metric(walked["of_session"], "range_of_motion", "index_pip")
    assert np.rad2deg(range_["value"]) == pytest.approx(TRUTH_DEG, abs=4.0)
    assert range_["lineage"]["source"] == "encoder"
    error = metric(walked["of_session"], "joint_rmse", "index_pip")
    assert np.isfinite(error["value"])
    assert "thesis gains" in error["lineage"]["conditions"]
    whole = metric(walked["of_session"], "joint_rmse", "whole")
    assert whole["value"] == pytest.approx(walked["played"]["rmse_rad"])


def test_the_session_names_the_take_it_was_made_from(walked):
    header = run(walked["data"], "info", walked["played"]["session"])
    assert header["parents"] == [walked["approval"]["sha256"]]
    assert header["side"] == "right"
    proof = run(walked["data"], "verify", walked["played"]["session"])
    session = metric(walked["of_session"], "joint_rmse", "whole")
    assert session["lineage"]["file_sha256"] == proof["sha256"] == walked["played"]["sha256"]
