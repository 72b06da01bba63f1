"""A passphrase that is tried on a busy machine: age times it, and a wrong answer must not be given."""

from __future__ import annotations

import pyrage
import pytest

from rehab_app.errors import Refused
from rehab_app.services import age, backup_key

PASSPHRASE = "a long sentence for the safe"
BUSY = "Excessive work parameter for passphrase.\nDecryption would take around 60 seconds."


class Busy:
    """age that finds the machine too slow so often."""

    def __init__(self, times):
        self.left = times

    def decrypt(self, locked, passphrase):
        self.left -= 1
        if self.left >= 0:
            raise pyrage.DecryptError(BUSY)
        return b"AGE-SECRET-KEY-"


def slow(monkeypatch, times):
    busy = Busy(times)
    monkeypatch.setattr(age._age, "passphrase", busy)
    return busy


def test_a_moment_of_load_is_tried_again(monkeypatch):
    busy = slow(monkeypatch, 2)
    assert backup_key.unlock(b"", PASSPHRASE) == "AGE-SECRET-KEY-"
    assert busy.left == -1


def test_a_machine_that_stays_too_slow_is_not_called_a_wrong_passphrase(monkeypatch):
    slow(monkeypatch, 100)
    with pytest.raises(Refused, match="more work than this machine") as refusal:
        backup_key.unlock(b"", PASSPHRASE)
    assert "wrong" not in str(refusal.value)


def test_a_wrong_passphrase_is_tried_once(monkeypatch):
    tried = []

    def decrypt(locked, passphrase):
        tried.append(passphrase)
        raise pyrage.DecryptError("Decryption failed")

    monkeypatch.setattr(age._age, "passphrase", type("Once", (), {"decrypt": staticmethod(decrypt)}))
    with pytest.raises(Refused, match="wrong"):
        backup_key.unlock(b"", PASSPHRASE)
    assert len(tried) == 1
