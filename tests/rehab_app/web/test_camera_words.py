"""Names, states and remedies of cameras in the language of the page."""

from __future__ import annotations

import pytest

from rehab_app.cameras import CameraListing
from rehab_app.cameras.drivers import _failed
from rehab_app.cameras.lost import missing_extra, missing_library
from rehab_app.web import words_cameras
from rehab_app.web.language import SOURCE, speak

LIBRARY = missing_library("Kinect", "libfreenect.so.0.5", "libfreenect0.5").remedy
EXTRA = missing_extra("RealSense camera", "realsense").remedy


def sentence(remedy):
    return f"{remedy[:1].upper()}{remedy[1:]}."


LISTED = (
    CameraListing("virtual", "Virtual camera", "ready", True),
    CameraListing("kinect", "Kinect (first generation)", "unavailable", True, sentence(LIBRARY)),
    CameraListing("webcam:0", "Studio <b>Cam</b>", "busy", False, "End the other recording first."),
)


@pytest.fixture
def italian():
    speak("it")
    yield
    speak(SOURCE)


@pytest.mark.parametrize(
    ("remedy", "told"),
    [
        (sentence(EXTRA), "Eseguire pip install 'rehab-app[realsense]'."),
        (sentence(LIBRARY), "Installarla (Debian: sudo apt-get install libfreenect0.5)."),
        (_failed("kinect").remedy, "scollegare la telecamera kinect"),
        ("End the other recording first.", "Terminare prima l'altra registrazione."),
        ("Ask 100 %(people)s.", "Ask 100 %(people)s."),
        ("", ""),
    ],
)
def test_what_to_do_is_told_in_the_language_of_the_page(italian, remedy, told):
    assert told in words_cameras.camera_remedy(remedy)


@pytest.mark.parametrize("remedy", [sentence(EXTRA), sentence(LIBRARY), _failed("openni").remedy, ""])
def test_in_english_it_is_what_the_camera_says(remedy):
    assert words_cameras.camera_remedy(remedy) == remedy


def test_both_pages_speak_it(browser, clinic, monkeypatch):
    monkeypatch.setattr("rehab_app.cameras.list_cameras", lambda: LISTED)
    monkeypatch.setattr("rehab_app.services.takes.list_cameras", lambda: LISTED)
    visitor = browser("therapist")
    page = visitor.get("/clinic/devices", **{"accept-language": "it"}).text
    rows = visitor.get("/live/cameras", **{"accept-language": "it"}).json()
    assert "Installarla (Debian: sudo apt-get install libfreenect0.5)." in page
    assert "Kinect (prima generazione)" in page
    assert "Studio &lt;b&gt;Cam&lt;/b&gt;" in page
    assert [row["words"] for row in rows] == [
        "Telecamera virtuale",
        "Kinect (prima generazione)",
        "Studio <b>Cam</b>",
    ]
    assert rows[1]["remedy"] == "Installarla (Debian: sudo apt-get install libfreenect0.5)."
    assert [row["state"] for row in rows] == ["ready", "unavailable", "busy"]
    assert rows[2]["state_words"] == "In uso"
    assert visitor.get("/live/cameras").json()[1]["remedy"] == sentence(LIBRARY)
