"""Who touches whom in the simulated hand, and that nothing explodes when they do."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

from robot_iface.kinematics import average_hand
from robot_iface.sim import DRIVEN, HandModel, build_model, device_capabilities, virtual_patient
from robot_iface.sim.engine import mujoco
from robot_iface.types import VIRTUAL_KINDS, Float64, Side, VirtualKind

CAPABILITIES = device_capabilities()
SIDES: tuple[Side, ...] = ("left", "right")


def built(
    length_m: float = 0.189, side: Side = "right", kind: VirtualKind = "healthy"
) -> tuple[HandModel, Any]:
    low, high = CAPABILITIES.q_min_rad, CAPABILITIES.q_max_rad
    hand = build_model(average_hand(length_m, side), virtual_patient(kind), low, high)
    data = mujoco.MjData(hand.model)
    data.qpos[hand.hand] = hand.rest_rad
    data.qpos[hand.robot] = data.qpos[hand.worn]
    return hand, data


def touching(hand: HandModel, data: Any) -> set[frozenset[str]]:
    return {
        frozenset(hand.model.geom(int(geom)).name.rsplit("_", 1)[0] for geom in pair)
        for pair in data.contact.geom
    }


def fist(hand: HandModel, data: Any, thumb_first: bool) -> tuple[set[frozenset[str]], float, float]:
    """Motors close the hand for 3 s; who touched, deepest dent in m, largest force in N."""
    pairs: set[frozenset[str]] = set()
    deepest, strongest, force = 0.0, 0.0, np.zeros(6)
    late = np.array([thumb_first != name.startswith("thumb") for name in DRIVEN])
    torque: Float64 = np.array([0.25 if "mcp" in name or "cmc" in name else 0.15 for name in DRIVEN])
    torque[DRIVEN.index("thumb_cmc_abduction")] = -0.15
    for tick in range(3000):
        now = np.where(late & (tick < 800), 0.0, torque)
        data.qfrc_applied[hand.robot] = now - 0.02 * data.qvel[hand.robot]
        mujoco.mj_step(hand.model, data)
        pairs |= touching(hand, data)
        for index in range(data.ncon):
            mujoco.mj_contactForce(hand.model, data, index, force)
            strongest = max(strongest, float(force[0]))
            deepest = max(deepest, -float(data.contact.dist[index]))
    return pairs, deepest, strongest


@pytest.mark.parametrize("kind", VIRTUAL_KINDS)
@pytest.mark.parametrize("side", SIDES)
def test_a_hand_at_rest_touches_nothing(kind: VirtualKind, side: Side) -> None:
    for length_m in (0.13, 0.189, 0.23):
        hand, data = built(length_m, side, kind)
        mujoco.mj_forward(hand.model, data)
        assert data.ncon == 0


@pytest.mark.parametrize("length_m", [0.13, 0.189, 0.22])
def test_a_thumb_tucked_into_a_fist_is_held_and_not_crushed(length_m: float) -> None:
    hand, data = built(length_m)
    pairs, deepest, strongest = fist(hand, data, thumb_first=True)
    assert any(name.startswith("thumb") for pair in pairs for name in pair)
    assert np.isfinite(data.qpos).all()
    assert np.abs(data.qvel).max() < 0.01, "it comes to rest"
    assert deepest < 0.005
    assert 1.0 < strongest < 10.0, "what 0.25 Nm at a lever of 3 to 8 cm can press"


def test_fingertips_stop_at_the_palm_and_only_plausible_pairs_touch() -> None:
    hand, data = built()
    pairs, _, _ = fist(hand, data, thumb_first=False)
    assert frozenset(("ring_2", "palm")) in pairs
    for pair in pairs:
        digits = {name.split("_")[0] for name in pair}
        assert len(digits) == 2
        assert digits & {"thumb", "palm"}, "fingers do not collide with one another"
        assert "palm" not in digits or not any(name.endswith("_0") for name in pair)


def may_touch(one: str, other: str) -> bool:
    """The rule of who may touch whom, by the names of two parts of the hand."""
    (first, bone), (second, _) = (name.split("_") for name in sorted((one, other), key=rank))
    if second == "palm":
        return bone == "2" if first == "thumb" else bone in ("1", "2")
    return first == "thumb" != second


def rank(name: str) -> int:
    return 0 if name.startswith("thumb") else 2 if name.startswith("palm") else 1


def test_just_the_pairs_that_a_hand_can_bring_together_are_tested() -> None:
    model = built()[0].model
    names = [model.geom(index).name.removesuffix("_skin") for index in range(model.ngeom)]
    assert len(names) == 15
    for i, j in itertools.combinations(range(model.ngeom), 2):
        takes, given = model.geom_conaffinity, model.geom_contype
        tested = bool(given[i] & takes[j] or given[j] & takes[i])
        one, other = (name if "_" in name else f"{name}_" for name in (names[i], names[j]))
        assert tested == may_touch(one, other), (one, other)


def test_a_fist_is_the_same_on_both_sides() -> None:
    ends = []
    for side in SIDES:
        hand, data = built(side=side)
        fist(hand, data, thumb_first=True)
        ends.append(data.qpos[hand.hand].copy())
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-6)


def test_without_skin_the_tips_sink_deeper() -> None:
    heights = []
    for disabled in (0, int(mujoco.mjtDisableBit.mjDSBL_CONTACT)):
        hand, data = built()
        hand.model.opt.disableflags |= disabled
        fist(hand, data, thumb_first=False)
        heights.append(float(data.site_xpos[hand.model.site("ring_tip").id][0]))
    assert heights[1] < heights[0] - 5e-4


@pytest.mark.parametrize("side", SIDES)
def test_the_palm_lies_under_all_four_knuckles(side: Side) -> None:
    geometry = average_hand(side=side)
    palm = built(side=side)[0].model.geom("palm_skin")
    across = (geometry.bases_m[1:] * geometry.mirror)[:, 1]
    low, high = palm.pos[1] - palm.size[1], palm.pos[1] + palm.size[1]
    assert across.min() - low == pytest.approx(high - across.max(), abs=1e-9)
    assert low < across.min() < across.max() < high
