"""Objects are what their names say, are read in place by the index, and every failure is one sentence."""

from __future__ import annotations

import hashlib
import shutil
from dataclasses import replace

import numpy as np
import pytest

from sessions.errors import Refused
from sessions.records import TOPICS
from sessions.store import SessionReader, verify
from sessions.store.object_source import ObjectSource, fetch_object, open_object
from sessions.store.object_store import ObjectPlace, ObjectStore
from sessions.store.object_trouble import Absent, Unreachable

SEED = 11


@pytest.fixture
def place(s3):
    return ObjectPlace(
        bucket="clinic-bucket",
        prefix="/one/",
        endpoint=s3.url,
        access_key="key",
        secret_key="secret",
        timeout_s=5.0,
        retries=0,
    )


@pytest.fixture
def store(place):
    return ObjectStore(place)


@pytest.fixture
def kept(store, sealed):
    """A sealed session in the store: key and digest."""
    sha256 = hashlib.sha256(sealed.read_bytes()).hexdigest()
    key = store.place.key("sessions", sha256)
    store.put(sealed, key)
    return key, sha256


def noise(path, length):
    path.write_bytes(np.random.default_rng(SEED).bytes(length))
    return path, hashlib.sha256(path.read_bytes()).hexdigest()


def test_key_says_digest_only(store):
    assert store.place.key("takes", "ab" * 32) == f"one/takes/{'ab' * 32}.mcap"
    assert replace(store.place, prefix="").key("takes", "cd") == "takes/cd.mcap"


def test_secret_is_never_shown(place):
    assert "secret" not in repr(place).replace("secret_key", "")


@pytest.mark.parametrize("length", [0, 1, 4 * 1024 * 1024 + 1, 9 * 1024 * 1024])
def test_put_proves_and_comes_back(store, tmp_path, length):
    """Also in parts, and twice is once."""
    path, sha256 = noise(tmp_path / "a.mcap", length)
    for _ in range(2):
        store.put(path, "k")
        store.prove("k", sha256, length)
    assert fetch_object(store, "k", sha256, tmp_path / "b.mcap") == length
    assert (tmp_path / "b.mcap").read_bytes() == path.read_bytes()


def test_put_leaves_what_is_there(store, tmp_path):
    first, sha256 = noise(tmp_path / "a.mcap", 100)
    store.put(first, "k")
    first.write_bytes(b"other")
    store.put(first, "k")
    store.prove("k", sha256, 100)


def test_any_range_is_the_files(store, tmp_path):
    """Blocks, kept or fetched, in any order and of any length, give the bytes of the file."""
    path, _ = noise(tmp_path / "a.mcap", 10_007)
    store.put(path, "k")
    content, rng = path.read_bytes(), np.random.default_rng(SEED)
    source = ObjectSource(store, "k", block_bytes=64, blocks_kept=5)
    for _ in range(60):
        start = int(rng.integers(0, len(content)))
        length = int(rng.integers(0, min(900, len(content) - start) + 1))
        assert source.read(start, length) == content[start : start + length]


def test_neighbours_come_in_one_request_and_stay(store, tmp_path):
    path, _ = noise(tmp_path / "a.mcap", 10_000)
    store.put(path, "k")
    source = ObjectSource(store, "k", block_bytes=1000, blocks_kept=10)
    source.read(3500, 1000)
    source.read(500, 8000)
    assert (source.requests, source.fetched_bytes) == (3, 9000)
    source.read(0, 9000)
    assert source.requests == 3


def test_session_is_read_in_place(store, kept, sealed, written):
    with open_object(store, kept[0], sealed) as there, SessionReader(sealed) as here:
        assert there.header == here.header
        assert there.counts == here.counts
        assert repr(there.overview()) == repr(here.overview())
        for name in written:
            assert len(list(there.records(TOPICS[name]))) == len(written[name])


def test_fetched_session_verifies(store, kept, tmp_path):
    target = tmp_path / "back.mcap"
    fetch_object(store, *kept, target)
    proof = verify(target)
    assert proof.digest_noted
    assert proof.sha256 == kept[1]


def test_flipped_bit_is_refused_with_key_and_digests(store, kept, sealed, tmp_path):
    spoilt = tmp_path / "spoilt.mcap"
    content = bytearray(sealed.read_bytes())
    content[len(content) // 2] ^= 1
    spoilt.write_bytes(content)
    store.replace(spoilt, kept[0])
    met = hashlib.sha256(content).hexdigest()
    for act in (
        lambda: store.prove(*kept, len(content)),
        lambda: fetch_object(store, *kept, tmp_path / "back.mcap"),
    ):
        with pytest.raises(Refused) as refusal:
            act()
        assert all(word in str(refusal.value) for word in (kept[0], kept[1], met))
    assert [path.name for path in tmp_path.iterdir()] == ["spoilt.mcap"]


def test_other_length_is_refused(store, kept, sealed):
    with pytest.raises(Refused, match="bytes, as the file"):
        store.prove(*kept, sealed.stat().st_size + 1)


def test_cut_download_leaves_no_file(s3, store, kept, tmp_path):
    s3.fault = "cut"
    with pytest.raises(Unreachable):
        fetch_object(store, *kept, tmp_path / "back.mcap")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"bucket": "other-bucket"}, "bucket 'other-bucket' is missing"),
        ({"endpoint": "http://127.0.0.1:9"}, "object store is not answering at http://127.0.0.1:9"),
    ],
)
def test_wrong_place_is_one_sentence(place, sealed, change, sentence):
    with pytest.raises(Unreachable, match=sentence) as refusal:
        ObjectStore(replace(place, **change)).put(sealed, "k")
    assert str(refusal.value).count("\n") == 0


@pytest.mark.parametrize(
    ("fault", "sentence"),
    [
        ("read-only", "closed to this access key"),
        ("wrong key", "access key of the object store is refused"),
        ("hang up", "not answering"),
    ],
)
def test_faults_on_the_way(s3, store, sealed, tmp_path, fault, sentence):
    """Nothing of a broken upload is met under its name, and once the fault is gone it goes through."""
    path, sha256 = noise(tmp_path / "a.mcap", 20 * 1024 * 1024)
    s3.fault, s3.passes = fault, 2  # the first part has gone through
    with pytest.raises(Unreachable, match=sentence):
        store.put(path, "k")
    s3.fault = ""
    assert store.size("k") is None
    store.put(path, "k")
    store.prove("k", sha256, path.stat().st_size)


def test_absent_object(store, tmp_path):
    assert store.size("nothing") is None
    store.delete("nothing")
    for act in (lambda: store.read("nothing", 0, 5), lambda: fetch_object(store, "n", "", tmp_path / "x")):
        with pytest.raises(Absent, match="not in bucket 'clinic-bucket'"):
            act()


def test_session_kept_elsewhere_is_untouched(sealed, kept, store, tmp_path):
    """Fetching over a damaged local file replaces it as a whole."""
    target = tmp_path / "x.mcap"
    shutil.copyfile(sealed, target)
    target.write_bytes(b"broken")
    fetch_object(store, *kept, target)
    assert target.read_bytes() == sealed.read_bytes()
