"""Markers named by hand through the service: a new take from the pictures of an old one."""

from __future__ import annotations

import numpy as np
import pytest

from rehab_app.access import CONSOLE, Account
from rehab_app.bootstrap import open_clinic
from rehab_app.cameras import virtual_camera
from rehab_app.errors import Refused
from rehab_app.hand.protocol import load_protocol
from rehab_app.services.recording_request import RecordingRequest
from rehab_app.services.take_sources import CYCLE_S
from rehab_app.tracking import Labels
from sessions.records.topics import CAMERA_COLOUR, MARKERS
from sessions.store import SessionReader, verify

PROTOCOL = load_protocol("thesis25")
SEED = 11
SECONDS = 1.6


@pytest.fixture(scope="module")
def clinic(tmp_path_factory):
    """One take with pictures and one without."""
    with open_clinic(tmp_path_factory.mktemp("pictured")) as opened:
        for consent in (True, False):
            request = RecordingRequest(
                exercise="open_close", side="right", seconds=SECONDS, seed=SEED, consent_images=consent
            )
            opened.takes.record(request, CONSOLE)
        yield opened


@pytest.fixture
def pictured(clinic):
    return clinic.takes.list()[-1]


@pytest.fixture
def bare(clinic):
    return clinic.takes.list()[-2]


def truth() -> Labels:
    """Where the markers truly are in the first picture, of those that can be seen."""
    camera = virtual_camera("open_close", "right", SECONDS, PROTOCOL, seed=SEED, period_s=CYCLE_S)
    pixel = camera.truth(0.0).pixel_px
    return Labels(PROTOCOL.names, np.asarray(pixel, dtype=np.float64))


def spots(path):
    """Names and points of every frame of a take."""
    with SessionReader(path) as reader:
        return {record.t_ns: record.p_camera_m for record in reader.records(MARKERS)}


def test_the_first_picture_shows_rings_where_the_markers_are(clinic, pictured):
    picture = clinic.marker_names.first_picture(pictured.id, CONSOLE)
    assert (picture.width_px, picture.height_px, picture.names) == (640, 480, PROTOCOL.names)
    assert picture.jpeg.startswith(b"\xff\xd8")
    apart = np.linalg.norm(picture.blobs_px[:, None] - truth().pixel_px, axis=2).min(axis=1)
    assert len(picture.blobs_px) >= 20
    assert (apart < 3.0).mean() > 0.9


def test_names_make_a_new_take_and_the_old_one_stays(clinic, pictured):
    before = pictured.path.read_bytes()
    made = clinic.marker_names.track_again(pictured.id, truth(), CONSOLE)
    assert made.parent == pictured.id
    assert made.take in clinic.takes.list()
    assert pictured.path.read_bytes() == before
    assert verify(made.take.path).sha256 == made.take.sha256
    with SessionReader(made.take.path) as reader:
        assert reader.header.parents == (pictured.sha256,)
        assert (reader.header.side, reader.header.exercise) == ("right", "open_close")
        assert not reader.header.consent_images
        assert CAMERA_COLOUR.name not in reader.counts
    assert made.result.measured_share > 0.85
    old, new = spots(pictured.path), spots(made.take.path)
    shared = sorted(set(old) & set(new))
    assert len(shared) > 40
    far = [np.nanmedian(np.linalg.norm(old[t] - new[t], axis=1)) for t in shared]
    assert np.median(far) < 0.002


def test_too_few_names_are_refused(clinic, pictured):
    told = truth()
    with pytest.raises(Refused, match="4 or more"):
        clinic.marker_names.track_again(pictured.id, Labels(told.names[:3], told.pixel_px[:3]), CONSOLE)


@pytest.mark.parametrize(
    ("name", "pixel", "words"),
    [("sixth_tip", (10.0, 10.0), "one of "), ("index_tip", (700.0, 10.0), "inside the picture")],
)
def test_wrong_labels_are_one_sentence(clinic, pictured, name, pixel, words):
    with pytest.raises(Refused) as refused:
        clinic.marker_names.track_again(pictured.id, Labels((name,), np.array([pixel])), CONSOLE)
    assert words in str(refused.value)
    assert name in str(refused.value)


def test_a_refusal_leaves_no_file(clinic, pictured):
    twice = Labels((PROTOCOL.names[0],) * 5, truth().pixel_px[:5])
    files = sorted(path.name for path in pictured.path.parent.iterdir())
    with pytest.raises(Refused, match="naming a marker twice"):
        clinic.marker_names.track_again(pictured.id, twice, CONSOLE)
    assert sorted(path.name for path in pictured.path.parent.iterdir()) == files


def test_a_take_without_pictures_says_why_not(clinic, bare):
    assert "no pictures" in clinic.marker_names.why_not(bare.id)
    with pytest.raises(Refused, match="no pictures"):
        clinic.marker_names.first_picture(bare.id, CONSOLE)
    with pytest.raises(Refused, match="no pictures"):
        clinic.marker_names.track_again(bare.id, truth(), CONSOLE)


def test_who_may_not_record_may_not_name(clinic, pictured):
    auditor = Account("otto", "auditor", "3")
    with pytest.raises(Refused):
        clinic.marker_names.first_picture(pictured.id, auditor)
    with pytest.raises(Refused):
        clinic.marker_names.track_again(pictured.id, truth(), auditor)
