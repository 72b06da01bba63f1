"""Diagnosis, bones and locks: stated, refused beside the field, never lost to a second editor."""

from __future__ import annotations

import pytest

from ..conftest import ATTACK
from .conftest import text_of


def test_the_record_is_stated_and_the_later_of_two_sees_both(browser, clinic, at):
    first, second = browser("therapist"), browser("administrator")
    assert "Nobody has stated a diagnosis" in first.get(at).text
    assert first.post(f"{at}/diagnosis", since="0", diagnosis="crps", mas="1+").status_code == 303
    answer = second.post(f"{at}/diagnosis", since="0", diagnosis="burn", insensate="yes")
    assert answer.status_code == 409
    told = text_of(answer)
    assert "therapist stated version" in told
    assert "Burn or contracture of the skin Complex regional pain syndrome" in told
    record = clinic.clinical.record(at.rsplit("/", 1)[1])
    assert record.diagnosis == "crps"
    assert f'name="since" value="{record.id}"' in answer.text
    assert "checked> The skin does not feel" in answer.text
    assert second.post(f"{at}/diagnosis", since=str(record.id), diagnosis="burn").status_code == 303


@pytest.mark.parametrize(
    ("fields", "field"),
    [
        ({"diagnosis": ""}, "diagnosis"),
        ({"diagnosis": "flu"}, "diagnosis"),
        ({"event_date": "2999-01-01"}, "event_date"),
        ({"event_date": "soon"}, "event_date"),
        ({"mas": "9"}, "mas"),
        ({"thumb_1": "45"}, "index_2"),
        ({"thumb_1": "4500"}, "thumb_1"),
    ],
)
def test_a_wrong_record_is_refused_beside_its_field(browser, clinic, at, fields, field):
    answer = browser("therapist").post(f"{at}/diagnosis", **{"since": "0", "diagnosis": "stroke", **fields})
    assert answer.status_code == 409
    assert f'href="#{field}"' in answer.text
    assert clinic.clinical.record(at.rsplit("/", 1)[1]) is None


def test_bones_are_kept_in_metres_and_shown_in_millimetres(browser, clinic, at):
    bones = {
        f"{digit}_{n}": "25,5" for digit in ("thumb", "index", "middle", "ring", "little") for n in (1, 2, 3)
    }
    visitor = browser("therapist")
    assert visitor.post(f"{at}/diagnosis", since="0", diagnosis="none", **bones).status_code == 303
    assert "0.0255" in clinic.clinical.record(at.rsplit("/", 1)[1]).bones_m
    assert (
        'name="ring_2" inputmode="decimal" aria-label="ring 2, mm" value="25.5"'
        in visitor.get(f"{at}/diagnosis").text
    )


def test_a_mode_is_unlocked_with_a_reason_and_locked_again(browser, clinic, at):
    therapist, assistant = browser("therapist"), browser("assistant")
    therapist.post(f"{at}/diagnosis", since="0", diagnosis="crps")
    answer = therapist.post(f"{at}/unlock", mode="passive", reason="")
    assert answer.status_code == 409
    assert 'id="reason_passive-problem"' in answer.text
    long = therapist.post(f"{at}/unlock", mode="passive", reason="y" * 501)
    assert "y" * 501 in long.text
    assert assistant.post(f"{at}/unlock", mode="passive", reason="x").status_code == 403
    assert therapist.post(f"{at}/unlock", mode="passive", reason=ATTACK).status_code == 303
    assert ATTACK not in therapist.get(at).text
    assert "Unlocked by therapist" in therapist.get(at).text
    assert assistant.post(f"{at}/lock", mode="passive").status_code == 303
    assert set(clinic.clinical.locks(at.rsplit("/", 1)[1])) == {"passive", "resistive"}
