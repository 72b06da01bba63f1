from __future__ import annotations

import pytest

from rehab_app.access import ROLES, VERBS, Account, RateLimit, hash_password, require, verify_password
from rehab_app.access.roles import role_named
from rehab_app.errors import Refused

# Which role may use which verb, written down a second time: a change of the table must be meant.
TABLE = {
    "administrator": set(VERBS),
    "therapist": {"view", "note", "record", "approve", "prescribe", "play", "stop", "clear_stop", "export"},
    "assistant": {"view", "note", "record", "play", "stop"},
    "patient": {"stop"},
    "auditor": {"view", "stop", "audit"},
}


@pytest.mark.parametrize("role", ROLES)
@pytest.mark.parametrize("verb", VERBS)
def test_every_role_may_use_exactly_its_verbs(role, verb):
    account = Account("somebody", role, "1")
    if verb in TABLE[role]:
        require(account, verb)
    else:
        with pytest.raises(Refused, match=r"somebody.*may not"):
            require(account, verb)


def test_everybody_may_stop():
    assert all("stop" in TABLE[role] for role in ROLES)


def test_an_unknown_role_is_refused():
    with pytest.raises(Refused, match="one of administrator"):
        role_named("root")


def test_a_password_is_salted_and_matches_only_itself():
    first, second = hash_password("a long sentence"), hash_password("a long sentence")
    assert first != second
    assert first.startswith("$argon2id$")
    assert verify_password(first, "a long sentence")
    assert not verify_password(first, "a long sentence ")


@pytest.mark.parametrize("stored", ["", "plain text", "$argon2id$v=19$m=1"])
def test_what_is_no_hash_matches_nothing(stored):
    assert not verify_password(stored, "")
    assert not verify_password(stored, stored)


@pytest.mark.parametrize("password", ["", "short", "x" * 201])
def test_a_password_out_of_bounds_is_refused(password):
    with pytest.raises(Refused, match="characters"):
        hash_password(password)


def test_the_sixth_try_within_the_window_is_refused_and_passes_later():
    now = [0.0]
    limit = RateLimit(5, 300.0, lambda: now[0])
    for second in range(5):
        limit.check("anna")
        now[0] = float(second)
        limit.fail("anna")
    with pytest.raises(Refused, match="wait 296 s"):
        limit.check("anna")
    limit.check("bert")
    now[0] = 300.0
    limit.check("anna")


def test_a_success_forgets_the_failures():
    limit = RateLimit(1, 300.0, lambda: 0.0)
    limit.fail("anna")
    limit.succeed("anna")
    limit.check("anna")
