"""Making therapy safer is anybody's at once; making it stronger is the therapist's."""

from __future__ import annotations

import pytest

from rehab_app.access import ROLES, Account
from rehab_app.errors import Refused
from rehab_app.services.live_controls import LiveControls

STRONGER = {
    "resume": lambda controls, account: controls.resume(account),
    "reverse": lambda controls, account: controls.reverse(account),
    "next": lambda controls, account: controls.advance(account),
    "faster": lambda controls, account: controls.set_speed(account, 0.9),
}
SAFER = {
    "pause": lambda controls, account: controls.pause(account),
    "slower": lambda controls, account: controls.set_speed(account, 0.3),
    "as fast": lambda controls, account: controls.set_speed(account, 0.5),
}


class Run:
    """A run at half speed that says what was asked of it."""

    speed = 0.5

    def __init__(self):
        self.asked = []

    def pause(self):
        self.asked.append("pause")

    def resume(self):
        self.asked.append("resume")

    def reverse(self):
        self.asked.append("reverse")

    def advance(self):
        self.asked.append("next")

    def set_speed(self, speed):
        self.asked.append(speed)


class Notes:
    def __init__(self):
        self.rows = []

    def note_later(self, actor, verb, subject="", detail=""):
        self.rows.append((actor, verb))


def asked_by(role, verb):
    run, notes = Run(), Notes()
    account = Account("somebody", role, "1")
    ({**SAFER, **STRONGER}[verb])(LiveControls(lambda: run, notes), account)
    assert len(run.asked) == len(notes.rows) == 1
    return account


@pytest.mark.parametrize("role", ROLES)
@pytest.mark.parametrize("verb", SAFER)
def test_safer_is_anybodys(role, verb):
    asked_by(role, verb)


@pytest.mark.parametrize("role", ROLES)
@pytest.mark.parametrize("verb", STRONGER)
def test_stronger_needs_the_role(role, verb):
    if Account("somebody", role, "1").may("play"):
        asked_by(role, verb)
    else:
        with pytest.raises(Refused, match="may not play"):
            asked_by(role, verb)


@pytest.mark.parametrize("role", ROLES)
def test_anybody_stops_and_enters_pain_and_only_some_clear(stocked, role):
    account = Account(role, role, "1")
    stocked.live.press_stop(role)
    stocked.live.pain(account)
    try:
        if account.may("clear_stop"):
            stocked.live.clear_stop(account, confirmed=True)
            assert not stocked.live.snapshot().stop_source
        else:
            with pytest.raises(Refused, match="may not clear stop"):
                stocked.live.clear_stop(account, confirmed=True)
    finally:
        stocked.live.clear_stop(Account("t", "therapist", "1"), confirmed=True)


@pytest.mark.parametrize("speed", [float("nan"), 0.05, -1.0, 2.0])
def test_a_speed_out_of_bounds_is_refused_from_anybody(speed):
    for role in ROLES:
        run = Run()
        with pytest.raises(Refused):
            LiveControls(lambda run=run: run, Notes()).set_speed(Account("x", role, "1"), speed)
        assert run.asked == []
