"""The files of the outbox: in order, whole or absent, never the same number twice."""

from __future__ import annotations

import stat
import threading

import pytest

from rehab_app.services.outbox_folder import OutboxFolder, Waiting
from rehab_app.services.outbox_reach import Reach
from sessions.errors import NoAnswer


def row(number, **content):
    return Waiting(f"{number:032x}", "audit", number, content or {"rows": []})


def test_rows_are_given_back_in_the_order_in_which_they_came(tmp_path):
    outbox = OutboxFolder(tmp_path)
    for number in range(1, 31):
        outbox.add(row(number, text="à\n\"'" * number))
    assert [letter.row for letter in OutboxFolder(tmp_path).waiting()] == [
        row(number, text="à\n\"'" * number) for number in range(1, 31)
    ]


def test_a_clinic_that_never_needed_it_has_no_folder(tmp_path):
    outbox = OutboxFolder(tmp_path)
    assert outbox.names() == ()
    assert list(outbox.waiting()) == []
    assert outbox.aside() == ()
    assert outbox.recordings() == frozenset()
    assert list(tmp_path.iterdir()) == []


def test_only_its_owner_may_read_it(tmp_path):
    outbox = OutboxFolder(tmp_path)
    path = outbox.add(row(1))
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert stat.S_IMODE(outbox.folder.stat().st_mode) == 0o700


def test_what_comes_at_the_same_moment_overwrites_nothing(tmp_path):
    outbox, together = OutboxFolder(tmp_path), threading.Barrier(8)

    def add(first):
        together.wait()
        for number in range(first, first + 25):
            outbox.add(row(number))

    threads = [threading.Thread(target=add, args=(1000 * one,)) for one in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    found = [letter.row.utc_ns for letter in outbox.waiting()]
    assert sorted(found) == sorted(1000 * one + more for one in range(8) for more in range(25))
    for one in range(8):  # each thread's own rows are in its order
        mine = [number for number in found if number // 1000 == one]
        assert mine == sorted(mine)


def test_a_half_written_file_is_never_a_row(tmp_path, monkeypatch):
    outbox = OutboxFolder(tmp_path)
    outbox.add(row(1))

    def full(_):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as broken:
        broken.setattr("rehab_app.services.outbox_folder.os.fsync", full)
        with pytest.raises(OSError, match="No space"):
            outbox.add(row(2))
    assert [letter.row for letter in outbox.waiting()] == [row(1)]
    assert not list(outbox.folder.glob(".*.part"))


def test_what_is_added_behind_while_others_go_is_found(tmp_path):
    outbox = OutboxFolder(tmp_path)
    outbox.add(row(1))
    seen = []
    for letter in outbox.waiting():
        seen.append(letter.row.utc_ns)
        if len(seen) < 4:
            outbox.add(row(len(seen) + 1))
        outbox.remove(letter.path)
    assert seen == [1, 2, 3, 4]
    assert outbox.names() == ()


def test_a_damaged_file_is_told_from_a_row(tmp_path):
    outbox = OutboxFolder(tmp_path)
    for content in (b"", b"{", b"\xff\xfe", b'{"id": 3}', b"[]"):
        outbox.add(row(1)).write_bytes(content)
    assert [letter.row for letter in outbox.waiting()] == [None] * 5


def test_one_delivers_at_a_time(tmp_path):
    one, other = OutboxFolder(tmp_path), OutboxFolder(tmp_path)
    with one.delivering() as mine, other.delivering() as theirs:
        assert mine
        assert not theirs
    with other.delivering() as again:
        assert again


def test_a_data_base_that_is_gone_is_asked_by_one_a_second():
    now_s = [100.0]
    reach = Reach(rest_s=1.0, clock_s=lambda: now_s[0])
    reach.check()
    reach.lost(NoAnswer("clinic data base", "not answering", "there", "wait"))
    assert reach.away
    with pytest.raises(NoAnswer):
        reach.check()
    now_s[0] += 1.0
    reach.check()  # this one asks, whoever comes meanwhile does not
    with pytest.raises(NoAnswer):
        reach.check()
    reach.answered()
    assert not reach.away
    reach.check()
    reach.check()
