"""The chain of the audit: followed whole, then what was added; what was changed does not stay hidden."""

from __future__ import annotations

import pytest
from sqlalchemy import text

from rehab_app.access import CONSOLE, Account
from rehab_app.errors import Refused
from rehab_app.services.audit import Audit
from rehab_app.services.audit_chain import WHOLE_NS, AuditChain, check_shown
from sessions.catalogue import Catalogue
from sessions.catalogue.audit import chained

NOON_NS = 1_790_000_000_000_000_000


class Clock:
    def __init__(self):
        self.now_ns = NOON_NS

    def __call__(self):
        return self.now_ns


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def catalogue(tmp_path):
    with Catalogue.open(tmp_path) as opened:
        for number in range(20):
            opened.record_audit("anna", "note", f"P-{number:04d}")
        yield opened


@pytest.fixture
def chain(catalogue, clock):
    return AuditChain(catalogue, clock)


@pytest.fixture
def followed(catalogue, monkeypatch):
    """From which row each following began."""
    begun, follow = [], catalogue.follow_audit

    def following(*after):
        begun.append(after[0].rows if after else 0)
        return follow(*after)

    monkeypatch.setattr(catalogue, "follow_audit", following)
    return begun


def damage(catalogue, statement):
    with catalogue._writing() as session:
        session.execute(text(statement))


def test_only_the_first_look_follows_the_whole_chain(catalogue, chain, followed):
    first = chain.look(())
    catalogue.record_audit("bert", "play", "P-0001")
    second = chain.look(catalogue.audit(5))
    assert (first.rows, first.since, second.rows, second.since) == (20, 0, 21, 1)
    assert second.head == catalogue.audit(1)[0].hash
    assert second.whole_utc_ns == NOON_NS
    assert followed == [0, 20]


def test_a_look_a_day_later_follows_it_whole_again(catalogue, chain, clock):
    chain.look(())
    clock.now_ns += WHOLE_NS - 1
    assert chain.look(()).whole_utc_ns == NOON_NS
    damage(catalogue, "UPDATE audit SET detail = 'x' WHERE seq = 7")
    assert chain.look(catalogue.audit(5)).problem == ""  # what the page says: followed at noon, not now
    clock.now_ns += 1
    assert "audit row 7" in chain.look(()).problem


def test_a_clock_that_was_set_back_follows_it_whole_again(catalogue, chain, clock):
    chain.look(())
    damage(catalogue, "UPDATE audit SET detail = 'x' WHERE seq = 7")
    clock.now_ns -= 10**9
    assert "audit row 7" in chain.look(()).problem


def test_whoever_asks_for_it_has_it_followed_whole(catalogue, chain):
    chain.look(())
    damage(catalogue, "UPDATE audit SET detail = 'x' WHERE seq = 7")
    assert "audit row 7" in chain.whole().problem


def test_a_changed_row_that_is_shown_is_found_at_once_and_the_first_one_named(catalogue, chain):
    chain.look(())
    damage(catalogue, "UPDATE audit SET detail = 'x' WHERE seq IN (7, 18)")
    assert "audit row 7" in chain.look(catalogue.audit(5)).problem
    assert chain.look(catalogue.audit(5)).whole_utc_ns == NOON_NS


@pytest.mark.parametrize(
    "statement",
    [
        "DELETE FROM audit WHERE seq = 3",
        "DELETE FROM audit WHERE seq = 1",
        "DELETE FROM audit WHERE seq > 12",
        "DELETE FROM audit",
        "UPDATE audit SET verb = 'x' WHERE seq = 20",
        "INSERT INTO audit SELECT 0, utc_ns, actor, verb, subject, detail, previous_hash, hash FROM audit"
        " WHERE seq = 3",
        "INSERT INTO audit SELECT 22, utc_ns, actor, verb, subject, detail, previous_hash, hash FROM audit"
        " WHERE seq = 3",
    ],
)
def test_rows_removed_slipped_in_or_cut_off_are_found_at_the_next_look(catalogue, chain, statement):
    chain.look(())
    damage(catalogue, statement)
    for _ in range(2):
        assert "audit row" in chain.look(()).problem
    assert chain.whole().problem


def test_a_chain_that_was_written_anew_is_not_the_one_that_was_followed(catalogue, chain):
    before = chain.look(())
    damage(catalogue, "DELETE FROM audit")
    for _ in range(30):
        catalogue.record_audit("somebody", "nothing", "")
    assert catalogue.verify_audit() == 30  # by itself it is whole
    for state in (chain.look(()), chain.whole(), chain.look(())):
        assert "audit row 20" in state.problem
        assert state.rows == 0
        assert state.whole_utc_ns == before.whole_utc_ns


def test_an_empty_audit_is_whole(tmp_path, clock):
    with Catalogue.open(tmp_path / "new") as empty:
        assert AuditChain(empty, clock).look(()).rows == 0


def test_neighbours_must_follow_from_each_other():
    first = chained(None, utc_ns=1, actor="anna", verb="note", subject="", detail="")
    second = chained(first, utc_ns=2, actor="anna", verb="note", subject="", detail="")
    third = chained(second, utc_ns=3, actor="anna", verb="note", subject="", detail="")
    other = chained(None, utc_ns=1, actor="anna", verb="note", subject="P-0001", detail="")
    check_shown((third, second, first))
    check_shown((third, first))
    with pytest.raises(Refused, match="audit row 2"):
        check_shown((second, other))


def test_words_of_the_filters_grow_with_the_audit(catalogue):
    audit, auditor = Audit(catalogue), Account("aud", "auditor", "1")
    assert audit.words(auditor) == (("anna",), ("note",))
    catalogue.record_audit("bert", "play", "P-0001")
    assert audit.words(auditor) == (("anna", "bert"), ("note", "play"))
    with pytest.raises(Refused):
        audit.look(Account("ass", "assistant", "1"), ())
    assert audit.state(CONSOLE).rows == 21
