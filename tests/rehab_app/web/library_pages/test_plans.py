"""Plans on the pages: made item by item, by those who may, and by two at once."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rehab_app.access import CONSOLE
from rehab_app.services.plan_items import PlanItem

from ..conftest import ATTACK
from .conftest import ITEM


def test_a_plan_is_made_item_by_item(browser, library, someone):
    visitor = browser("therapist")
    assert "Nothing is prescribed yet" in visitor.get(f"/patients/{someone}/plan").text
    chosen = visitor.get(f"/prescribe?patient={someone}&exercise=place_and_hold").headers["location"]
    form = visitor.get(chosen.partition("#")[0]).text
    assert '<option value="place_and_hold" selected>' in form
    assert 'name="hold_s" inputmode="decimal" value="10"' in form
    assert visitor.post(f"/patients/{someone}/plan/item", **ITEM).status_code == 303
    plan = library.plans.current(someone)
    item = plan.items[0]
    assert (item.exercise, item.minutes, item.speed, item.warm_up, plan.by) == (
        "pinch",
        8.5,
        0.5,
        2,
        "therapist",
    )
    more = {**ITEM, "exercise": "wave", "version": str(plan.version)}
    visitor.post(f"/patients/{someone}/plan/item", **more)
    plan = library.plans.current(someone)
    visitor.post(f"/patients/{someone}/plan/move", version=str(plan.version), key="2", how="up")
    plan = library.plans.current(someone)
    assert [item.exercise for item in plan.items] == ["wave", "pinch"]
    frame = {"version": str(plan.version), "sessions_per_week": "5", "goal": f"A glass {ATTACK}"}
    visitor.post(f"/patients/{someone}/plan/frame", **frame)
    text = visitor.get(f"/patients/{someone}/plan").text
    assert "5 sessions a week" in text
    assert ATTACK not in text
    assert "no approved take" in text


def test_an_assistant_may_lessen_but_not_strengthen(browser, library, someone):
    asked = replace(library.plans.current(someone), items=(PlanItem(exercise="pinch", repetitions=20),))
    plan = library.plans.change(CONSOLE, asked)
    fields = {
        **ITEM,
        "key": "1",
        "part": "active",
        "mode": "passive",
        "minutes": "5",
        "hold_s": "0.5",
        "warm_up": "0",
    }
    fields["version"] = str(plan.version)
    stronger = browser("assistant").post(f"/patients/{someone}/plan/item", **{**fields, "repetitions": "30"})
    assert stronger.status_code == 409
    assert "stronger or another treatment (pinch: more repetitions)" in stronger.text
    assert 'name="repetitions" inputmode="numeric" value="30"' in stronger.text
    browser("assistant").post(f"/patients/{someone}/plan/item", **{**fields, "repetitions": "5"})
    assert library.plans.current(someone).items[0].repetitions == 5
    plan = library.plans.current(someone)
    browser("assistant").post(
        f"/patients/{someone}/plan/move", version=str(plan.version), key="1", how="remove"
    )
    assert library.plans.current(someone).items == ()


def test_two_people_at_one_plan(browser, library, someone):
    """The later is told; both texts are on the page, and saving again takes it."""
    browser("therapist").post(f"/patients/{someone}/plan/item", **{**ITEM, "remark": "the first text"})
    late = browser("therapist").post(
        f"/patients/{someone}/plan/item", **{**ITEM, "remark": "the second text"}
    )
    assert late.status_code == 409
    assert "changed by therapist meanwhile" in late.text
    assert "the first text" in late.text
    assert "the second text" in late.text
    version = library.plans.current(someone).version
    assert f'name="version" value="{version}"' in late.text
    again = {**ITEM, "remark": "the second text", "version": str(version)}
    browser("therapist").post(f"/patients/{someone}/plan/item", **again)
    remarks = [item.remark for item in library.plans.current(someone).items]
    assert remarks == ["the first text", "the second text"]


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("minutes", "0"),
        ("minutes", "nan"),
        ("repetitions", "-1"),
        ("repetitions", "1e3"),
        ("speed", "0"),
        ("warm_up", "21"),
        ("part", "dinner"),
        ("support", "much"),
        ("mode", "dance"),
        ("exercise", "juggling"),
        ("take", "ffffffff"),
        ("remark", "x" * 10_000),
        ("version", "x"),
    ],
)
def test_a_wrong_item_comes_back_in_a_sentence(browser, library, someone, name, value):
    typed = {**ITEM, "reason": "my own reason", name: value}
    answer = browser("therapist").post(f"/patients/{someone}/plan/item", **typed)
    assert answer.status_code == 409
    assert 'role="alert"' in answer.text
    assert "my own reason" in answer.text
    assert library.plans.current(someone).version == 0
