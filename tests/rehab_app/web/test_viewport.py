"""The picture: hands on their bones, words that are escaped, servers on loopback only."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from ipaddress import ip_address
from types import SimpleNamespace
from typing import Any, get_args

import numpy as np
import pytest

from rehab_app.errors import Refused
from rehab_app.services.rows import Replay
from rehab_app.services.snapshot import LiveSnapshot, LiveState
from rehab_app.web.language import speak
from rehab_app.web.screens import Screens
from rehab_app.web.viewport import LOOPBACK, LiveViewport, ReviewViewports
from rehab_app.web.viewport.hand_shape import HandShape
from rehab_app.web.viewport.painter import Painter
from rehab_app.web.viewport.private_server import PrivateServer
from rehab_app.web.viewport.review import ReviewViewport
from rehab_app.web.viewport.solids import ball, loft, tapered_bone
from rehab_app.web.viewport.verdict import Verdict, legend, lines, of_error
from rehab_app.web.viewport.words import PHASES, facts_of, verdict_of
from robot_iface.kinematics import JOINT_MAX_RAD, JOINT_MIN_RAD, average_hand, forward
from robot_iface.types import Side

GEOMETRY = average_hand()


def replay() -> Replay:
    t_s = np.arange(0.0, 2.0, 0.02)
    joints = np.zeros((t_s.size, 21))
    joints[:, 7] = 0.5 * t_s
    return Replay(
        t_s=t_s,
        reference_joints_rad=joints,
        patient_joints_rad=0.9 * joints,
        fingertip_error_m=0.004 * t_s,
        phases=("move",) * t_s.size,
        events=(),
        geometry=GEOMETRY,
        side="right",
        reference_geometry=GEOMETRY,
    )


@dataclass
class Desk:
    shown: LiveSnapshot

    def snapshot(self) -> LiveSnapshot:
        return self.shown

    def camera_jpeg(self) -> bytes | None:
        return None

    def error_history(self) -> tuple[Any, Any]:
        return np.arange(3.0), np.array([1.0, np.nan, 2.0])


@pytest.mark.parametrize("side", ["left", "right"])
def test_the_drawn_hand_lies_on_its_bones(side: Side) -> None:
    hand = average_hand(side=side)
    joints = np.random.default_rng(3).uniform(JOINT_MIN_RAD, JOINT_MAX_RAD)
    segments, balls = HandShape(hand).pose(joints)
    points = forward(hand, joints).landmarks_m[:20].reshape(5, 4, 3)
    np.testing.assert_allclose(segments.p_palm_m.reshape(5, 3, 3), points[:, :3])
    np.testing.assert_allclose(balls.p_palm_m[:20].reshape(5, 4, 3)[:, :3], points[:, :3])
    np.testing.assert_allclose(np.linalg.norm(segments.q_palm_wxyz, axis=1), 1.0)
    inside = np.linalg.norm(balls.p_palm_m[:20].reshape(5, 4, 3)[:, 3] - points[:, 3], axis=1)
    assert (inside < 0.01).all()


@pytest.mark.parametrize(
    "solid",
    [tapered_bone(), ball(), HandShape(GEOMETRY).palm(), HandShape(average_hand(side="left")).palm()],
    ids=["bone", "ball", "right palm", "left palm"],
)
def test_solids_are_closed_and_face_outwards(solid: Any) -> None:
    edges = np.concatenate([solid.faces[:, [0, 1]], solid.faces[:, [1, 2]], solid.faces[:, [2, 0]]])
    assert {tuple(edge) for edge in edges} == {tuple(edge[::-1]) for edge in edges}
    corners = solid.vertices_m[solid.faces]
    volume = np.einsum("fi,fi->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    assert volume > 0


def test_a_loft_passes_through_its_stations() -> None:
    stations = np.array([[0.0, 0.0, 0.0, 1.0, 2.0], [1.0, 0.5, 0.0, 2.0, 3.0], [2.0, 0.0, 0.0, 1.0, 1.0]])
    heights = loft(stations).vertices_m[:, 2]
    assert (heights.min(), heights.max()) == (0.0, 2.0)


def test_the_verdict_names_the_worst_finger_and_never_relies_on_colour() -> None:
    good = of_error(np.full(5, 0.002))
    bad = of_error(np.array([0.002, 0.002, 0.03, 0.002, 0.002]))
    assert (good.word, good.number, good.unit) == ("Within target", "2.0", "mm RMS")
    assert bad.word == "Off target"
    assert "middle, 30.0 mm" in bad.detail
    assert good.html() != replace(good, style="caution").html()


def test_text_is_escaped() -> None:
    attack = '<img src=x onerror="alert(1)">'
    for html in (Verdict("calm", attack, attack, attack, attack).html(), lines(((attack, attack),))):
        assert "<img" not in html


@pytest.mark.parametrize(
    "state",
    ["idle", "countdown", "recording", "processing", "rehearsing", "playing", "stopped", "done", "failed"],
)
def test_every_state_has_its_words(state: Any) -> None:
    shown = verdict_of(LiveSnapshot(state=state, message="m"))
    assert shown.word
    facts = dict(
        facts_of(
            LiveSnapshot(
                state="playing", kind="therapy", repetitions=5, repetition=1, support=2.0, phase="cue"
            )
        )
    )
    assert facts["Repetition"] == "2 of 5"
    assert facts["Support"].startswith("50 %")


def test_the_live_server_listens_where_no_other_page_looks() -> None:
    clinic: Any = SimpleNamespace(live=Desk(LiveSnapshot(state="playing", patient_joints_rad=np.zeros(21))))
    viewport = LiveViewport(clinic)
    try:
        assert ip_address(LOOPBACK).is_loopback
        socket.create_connection((LOOPBACK, viewport.port), timeout=5).close()
        for elsewhere in ("127.0.0.1", socket.gethostbyname(socket.gethostname())):
            if elsewhere != LOOPBACK:
                with pytest.raises(OSError, match=r"refused|unreachable"):
                    socket.create_connection((elsewhere, viewport.port), timeout=5)
    finally:
        viewport.close()


def test_no_client_can_ask_for_a_public_tunnel(monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[Any] = []
    monkeypatch.setattr("viser._viser.ViserTunnel", lambda *words, **_: opened.append(words))
    server = PrivateServer("test")
    try:
        assert server.request_share_url() is None
    finally:
        server.stop()
    assert opened == []


def test_reviews_are_reused_and_the_oldest_is_closed() -> None:
    asked: list[str] = []

    def replay_of(named: str) -> Replay:
        if named == "unknown":
            raise Refused("session", "unknown", "recorded", "choose another")
        asked.append(named)
        return replay()

    clinic: Any = SimpleNamespace(sessions=SimpleNamespace(replay=replay_of))
    reviews = ReviewViewports(clinic, most=2)
    try:
        first = reviews.port_for("a")
        assert reviews.port_for("a") == first
        assert reviews.port_for("b") != first
        reviews.port_for("c")
        reviews.port_for("a")
        assert asked == ["a", "b", "c", "a"]
        with pytest.raises(Refused, match="unknown"):
            reviews.port_for("unknown")
    finally:
        reviews.close()


def test_a_picture_goes_on_after_a_browser_left_in_the_middle_of_a_turn():
    turns = []
    again = threading.Event()

    def paint():
        turns.append(1)
        if len(turns) == 1:
            raise RuntimeError("deque mutated during iteration")
        again.set()
        return 0.01

    painter = Painter(SimpleNamespace(server=SimpleNamespace(stop=lambda: None)), "painter", paint)
    assert again.wait(10.0)
    painter.close()


ITALIAN = "it"


@pytest.fixture
def italian() -> Iterator[None]:
    speak(ITALIAN)
    yield
    speak("en")


@pytest.mark.usefixtures("italian")
def test_the_panel_speaks_the_language_of_its_page() -> None:
    bad = of_error(np.array([0.002, 0.002, 0.0305, 0.002, 0.002]))
    assert (bad.word, bad.number) == ("Fuori obiettivo", "13,8")
    assert "medio, 30,5 mm" in bad.detail
    shown = LiveSnapshot(
        state="playing", kind="therapy", repetitions=5, repetition=1, support=1.5, interaction_nm=0.25
    )
    facts = dict(facts_of(shown))
    assert facts["Ripetizione"] == "2 di 5"
    assert facts["Coppia sulla mano"] == "0,25 Nm"
    assert "×1,5" in facts["Supporto"]
    assert "Paziente, pieno" in legend(comparing=True, target=False)


@pytest.mark.parametrize("state", get_args(LiveState))
@pytest.mark.usefixtures("italian")
def test_no_state_is_said_in_english(state: Any) -> None:
    for phase in ("", *PHASES):
        said = verdict_of(LiveSnapshot(state=state, phase=phase)).word
        speak("en")
        english = verdict_of(LiveSnapshot(state=state, phase=phase)).word
        speak(ITALIAN)
        assert said != english, english


def test_each_language_has_a_live_picture_of_its_own() -> None:
    clinic: Any = SimpleNamespace(live=Desk(LiveSnapshot(state="idle")))
    screens = Screens(clinic)
    try:
        english = screens.live_port()
        speak(ITALIAN)
        other = screens.live_port()
        assert other not in (english, 0)
        assert screens.live_port() == other
        viewport = screens._live[ITALIAN]
        eventually(lambda: "Pronto" in viewport._panel._card.content)
        speak("en")
        assert screens.live_port() == english
        assert "Ready" in screens._live["en"]._panel._card.content
    finally:
        speak("en")
        screens.close()


def eventually(true: Callable[[], bool]) -> None:
    waiting = threading.Event()
    for _ in range(200):
        if true():
            return
        waiting.wait(0.05)
    raise AssertionError("it never became true")


def test_an_italian_replay_is_moved_by_its_own_buttons() -> None:
    speak(ITALIAN)
    try:
        viewport = ReviewViewport(replay(), "Review", replay())
    finally:
        speak("en")  # clicks come on threads that know no language
    try:
        transport, second = viewport._transport, viewport._second
        transport.play(False)
        assert transport._button.label == "Esegui"
        assert second is not None
        second._align.value = second._by_time
        times = np.array([0.5])
        assert second.time_s(times) is times
    finally:
        viewport.close()
