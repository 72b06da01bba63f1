from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest

from sessions.errors import Refused
from sessions.metrics import measure
from sessions.records.topics import EVENTS, PATIENT_POSE, PHASE, ROBOT_COMMAND
from sessions.reports import Report, build_report, render_html, render_json, report_object
from sessions.reports.sentences import sentences

Make = Callable[..., Any]
KEYS = {"name", "subject", "value", "unit", "interval", "version", "status", "lineage"}


def report(*recordings: Any) -> Report:
    return Report(tuple(measure(item) for item in recordings), "0.1.0")


class Words(HTMLParser):
    """Visible text and ids of a page."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.text: list[str] = []
        self.ids: list[str] = []
        self.tags: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.ids += [value for name, value in attrs if name == "id" and value]

    def handle_data(self, data: str) -> None:
        self.text.append(data)

    @property
    def all(self) -> str:
        return re.sub(r"\s+", " ", " ".join(self.text))


def test_json_holds_what_the_contract_names(make_take: Make, make_session: Make) -> None:
    content = json.loads(render_json(report(make_take(), make_session())))
    assert set(content) == {"metrics", "sessions", "software_version"}
    assert all(set(item) == KEYS for item in content["metrics"])
    assert [item["kind"] for item in content["sessions"]] == ["take", "therapy"]
    found = {
        (item["name"], item["subject"]): item for item in content["metrics"] if "b2b2" in str(item["lineage"])
    }
    pip = found["joint_rmse", "index_pip"]
    assert pip["value"] == pytest.approx(np.deg2rad(3.0))
    assert (pip["unit"], pip["version"], pip["status"]) == ("rad", "2", "ok")
    assert pip["interval"][0] < pip["value"] < pip["interval"][1]
    assert pip["lineage"]["topics"] == ["/patient/pose", "/therapy/reference", "/therapy/phase"]
    assert "0.90 Nm/rad" in pip["lineage"]["conditions"]
    assert [item["index"] for item in content["sessions"][1]["repetitions"]] == [0, 1, 2]


def test_no_nan_in_json_but_null_with_a_reason(make_take: Make) -> None:
    content = report_object(report(make_take()))
    json.dumps(content, allow_nan=False)
    missing = [item for item in content["metrics"] if item["value"] is None]
    assert missing
    assert all(item["status"].startswith("not measurable: ") for item in missing)
    assert all(item["interval"] is None for item in missing)


def test_same_input_same_bytes_and_every_id_once(make_take: Make, make_session: Make) -> None:
    first = report(make_take(), make_session(), make_session())
    page = render_html(first)
    assert page == render_html(report(make_take(), make_session(), make_session()))
    assert render_json(first) == render_json(report(make_take(), make_session(), make_session()))
    ids = Words(page).ids
    assert len(ids) == len(set(ids))
    for target in re.findall(r'(?:href="|url\()#([^")]+)', page):
        assert target in ids


def test_the_page_needs_nothing_else(make_session: Make) -> None:
    page = render_html(report(make_session()))
    tags = Words(page).tags
    assert not {"script", "link", "img", "iframe", "object"} & set(tags)
    loaded = re.findall(r'(?:src|href)="([^"]+)"', page) + re.findall(r"url\(([^)]+)\)", page)
    assert all(target.startswith("#") for target in loaded)


def test_a_session_page_says_what_it_must(make_session: Make) -> None:
    words = Words(render_html(report(make_session()))).all
    assert "not a certified medical device" in words
    assert "stiffness 0.90 Nm/rad (3.0 times the thesis gains), passive mode" in words
    assert "The robot moved your hand through 3 full repetitions, all that were planned." in words
    assert "Your hand moved most at the index finger, middle joint (PIP): 40.0° from end to end." in words
    assert "b2" * 32 in words
    assert "Joint error (°)" in words
    assert "Fingertip error (mm)" in words


def test_error_is_hidden_where_the_stiffness_is_unknown(make_session: Make) -> None:
    session = make_session().without(ROBOT_COMMAND)
    session.topics[PHASE.name]["assistance"][:] = np.nan
    made = report(session)
    words = Words(render_html(made)).all
    assert "cannot be told: the stiffness at which it was obtained is not in the file" in words
    assert "so no error is shown" in words
    values = [
        item["value"]
        for item in report_object(made)["metrics"]
        if item["name"] in ("joint_rmse", "fingertip_rmse")
    ]
    assert values
    assert not any(value is not None for value in values)


def test_overlay_is_blue_and_solid_beside_orange_and_dashed(make_session: Make) -> None:
    page = render_html(report(make_session()))
    assert "#0072b2" in page
    dashed = [
        style for style in re.findall(r'style="([^"]*stroke-dasharray[^"]*)"', page) if "#c94f00" in style
    ]
    assert dashed
    solid = [style for style in re.findall(r'style="([^"]*#0072b2[^"]*)"', page) if "dasharray" not in style]
    assert solid


def test_words_from_a_file_cannot_become_markup(make_session: Make) -> None:
    session = make_session(stopped=True)
    evil = '<script>alert("x")</script>'
    session.header = replace(session.header, exercise=evil, subject_id=evil, limits=json.dumps({evil: evil}))
    session.topics[EVENTS.name]["text"] = np.array([evil, evil])
    session.topics[PHASE.name]["mode"] = np.full(len(session.topics[PHASE.name]["mode"]), evil)
    session.topics[PATIENT_POSE.name]["source"] = np.array(
        [evil] * len(session.topics[PATIENT_POSE.name]["t_ns"])
    )
    page = render_html(report(session))
    assert "<script" not in page
    assert "alert" in page


def test_a_take_page(make_take: Make) -> None:
    words = Words(render_html(report(make_take()))).all
    assert "lasts 10.0 s and shows 3 full repetitions" in words
    assert "The least seen marker (Thumb CMC) was seen in 95 % of the frames." in words
    assert "Fit residual (mm) 1.2" in words
    assert "therapist" not in words.lower().replace("against the therapist", "")


def test_stops_are_told_first(make_session: Make) -> None:
    summary = measure(make_session(stopped=True))
    assert sentences(summary)[0] == (
        "The robot moved your hand through 2 full repetitions of 3 that were planned; it was stopped once."
    )
    assert "The stop button was pressed." in Words(render_html(Report((summary,), "0.1.0"))).all


def test_a_hand_that_was_never_seen_gives_a_page_of_reasons(make_take: Make) -> None:
    take = make_take()
    take.topics["/hand/pose"]["joint_status"][:] = 0
    take.topics["/hand/pose"]["joints_rad"][:] = np.nan
    take.topics["/hand/pose"]["fingertips_palm_m"][:] = np.nan
    words = Words(render_html(report(take))).all
    assert "not seen well enough" in words
    assert "so there is no picture" in words
    assert "an unknown number of repetitions" in words
    assert "nan" not in re.findall(r"\w+", words.lower())


def test_about_no_file_is_refused() -> None:
    with pytest.raises(Refused, match="no file"):
        build_report([])


def test_matplotlib_is_loaded_only_for_drawing() -> None:
    code = "import sys, sessions.reports; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
