"""A recording whose process is killed outright loses at most its last second."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np

from sessions.records.topics import EVENTS, HAND_JOINTS
from sessions.store import SessionReader, partials, recover, verify

PERIOD_NS = 10_000_000
SECOND_NS = 1_000_000_000
CHILD = """
import sys
from pathlib import Path
import numpy as np
from sessions.records import JOINTS, Event, JointStates, SessionHeader
from sessions.records.topics import EVENTS, HAND_JOINTS
from sessions.store import SessionWriter

header = SessionHeader(
    session_id="0" * 32, kind="take", subject_id="p", side="right", exercise="e", source="s",
    software_version="0", utc_start_ns=10**18, monotonic_start_ns=0,
)
writer = SessionWriter(Path(sys.argv[1]), header)
index = 0
while True:
    t_ns = index * 10_000_000
    writer.write(HAND_JOINTS, JointStates(t_ns=t_ns, names=JOINTS, positions_rad=np.full(21, float(index))))
    if index % 500 == 0:
        writer.write(EVENTS, Event(t_ns=t_ns, kind="note", severity="info", cause="x", category="",
                                   subject="", value=float(index), bound=0.0, text=""))
    index += 1
    if index % 250 == 0:
        print(t_ns, flush=True)
"""


def test_sigkill_loses_at_most_the_last_second(tmp_path: Path) -> None:
    path = tmp_path / "walk.mcap"
    child = subprocess.Popen([sys.executable, "-c", CHILD, str(path)], stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None
    with child, child.stdout:
        reported_ns = 0
        while reported_ns < 60 * SECOND_NS:
            reported_ns = int(child.stdout.readline())
        child.kill()
        assert child.wait() == -9
        rest = child.stdout.read().split()
    reported_ns = max(reported_ns, *(int(word) for word in rest)) if rest else reported_ns

    assert not path.exists()
    assert partials(tmp_path) == (tmp_path / "walk.partial.mcap",)
    found = recover(tmp_path / "walk.partial.mcap")
    assert found.sealed.path == path
    assert (found.lost_chunks, found.lost_records) == (0, 0)
    proof = verify(path)
    assert proof.sha256 == found.sealed.sha256
    assert sum(proof.records.values()) == found.records
    with SessionReader(path) as reader:
        columns = reader.columns(HAND_JOINTS)
        events = reader.columns(EVENTS)
    assert columns.t_ns[-1] >= reported_ns - SECOND_NS
    np.testing.assert_array_equal(columns.t_ns, np.arange(columns.rows) * PERIOD_NS)
    np.testing.assert_array_equal(columns["positions_rad"][:, 20], np.arange(columns.rows))
    np.testing.assert_array_equal(events["value"], np.arange(0, columns.rows, 500)[: events.rows])
