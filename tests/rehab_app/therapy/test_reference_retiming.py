from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rehab_app.recording.importers import import_recording
from rehab_app.recording.take import HandMotion, read_motion
from rehab_app.therapy.reference import BuiltReference, build_reference
from rehab_app.therapy.reference_retiming import MOST, Retimed, retime, stretch
from rehab_app.therapy.reference_speed import fastest, instants
from robot_iface.build import capabilities
from robot_iface.kinematics import average_hand
from robot_iface.motion import QuinticPath, check_path
from robot_iface.safety import shipped_limits
from robot_iface.types import Limits, ReferencePath
from sessions.errors import Refused
from sessions.records.fields import Float64
from sessions.store import SessionReader

JOINTS = ("index_mcp_flexion", "index_pip", "ring_pip")
TICK_S = 0.001


def limits(flexion_deg_s: float = 60.0, extension_deg_s: float = 30.0) -> Limits:
    ones = np.ones(len(JOINTS))
    return Limits(
        q_min_rad=-ones,
        q_max_rad=2.0 * ones,
        flexion_speed_rad_s=np.deg2rad(flexion_deg_s) * ones,
        extension_speed_rad_s=np.deg2rad(extension_deg_s) * ones,
        tau_interaction_nm=0.25 * ones,
        tau_nm=0.6 * ones,
    )


def path_of(q_rad: Float64, step_s: float = 0.02) -> ReferencePath:
    return ReferencePath(JOINTS, step_s * np.arange(len(q_rad)), q_rad, "0" * 64, "right")


def one_fast_spot(fast_rad: float = 1.0) -> ReferencePath:
    """30 s of slow waves; the index PIP opens within half a second at 15 s and closes at leisure."""
    t_s = 0.02 * np.arange(1501)
    slow = 0.3 + 0.05 * np.sin(2 * np.pi * t_s[:, None] / np.array([10.0, 15.0, 7.5]))
    slow[:, 1] += fast_rad * (1 / (1 + np.exp(np.clip((t_s - 15) / 0.06, -50, 50))))
    return path_of(slow)


def restless(seed: int) -> ReferencePath:
    """10 s of smooth random movement with many fast spots."""
    rng = np.random.default_rng(seed)
    t_s = 0.02 * np.arange(501)
    waves = rng.uniform(0.3, 2.0, (6, 3))
    phase = rng.uniform(0, 2 * np.pi, (6, 3))
    return path_of(0.5 + 0.1 * np.sin(2 * np.pi * waves * t_s[:, None, None] + phase).sum(axis=1))


def exact_from_s(original: QuinticPath, done: Retimed, path_s: Float64) -> Float64:
    """Where points of a re-timed path lie on the original one: nearest posture near the expected place."""
    guess = np.interp(path_s, done.path.t_s, done.from_s)
    offsets = np.linspace(-0.01, 0.01, 41)
    tried = np.clip(guess[:, None] + offsets, 0.0, original.duration_s)
    postures = original.sample(tried.ravel()).reshape(*tried.shape, -1)
    here = QuinticPath(done.path).sample(path_s)
    nearest = np.argmin(((postures - here[:, None]) ** 2).sum(axis=2), axis=1)
    return np.take_along_axis(tried, nearest[:, None], axis=1)[:, 0]


@pytest.mark.parametrize("speed", [0.25, 0.5, 1.0])
@pytest.mark.parametrize("seed", range(3))
def test_limits_hold_wherever_the_player_looks(seed: int, speed: float) -> None:
    path, bounds = restless(seed), limits()
    assert check_path(QuinticPath(path), bounds, speed, TICK_S) is not None
    done = retime(path, bounds, speed)
    spline = QuinticPath(done.path)
    assert check_path(spline, bounds, speed, TICK_S) is None
    assert fastest(spline, bounds)[0] >= speed * (1 - 1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_a_path_too_rough_for_its_knots_is_slowed_until_the_new_spline_keeps_the_limits(seed: int) -> None:
    path = path_of(0.5 + 0.005 * np.random.default_rng(seed).standard_normal((400, 3)))
    done = retime(path, limits(), 0.5)
    assert fastest(QuinticPath(done.path), limits())[0] >= 0.5 * (1 - 1e-12)
    assert check_path(QuinticPath(done.path), limits(), 0.5, TICK_S) is None


@pytest.mark.parametrize("path", [one_fast_spot(), restless(5)])
def test_the_same_postures_in_the_same_order(path: ReferencePath) -> None:
    done = retime(path, limits(), 1.0)
    original, spline = QuinticPath(path), QuinticPath(done.path)
    np.testing.assert_array_equal(done.path.q_rad, original.sample(done.from_s))
    assert bool(np.all(np.diff(done.from_s) > 0))
    assert done.from_s[0] == 0.0
    assert done.from_s[-1] == path.t_s[-1]
    between_s = np.linspace(0.0, spline.duration_s, 3001)
    on_s = exact_from_s(original, done, between_s)
    assert np.abs(spline.sample(between_s) - original.sample(on_s)).max() < np.deg2rad(0.05)


def test_time_passes_and_is_never_gained() -> None:
    done = retime(restless(6), limits(), 1.0)
    steps_s = np.diff(done.path.t_s)
    assert bool(np.all(steps_s > 0))
    assert np.ptp(steps_s) < 1e-9
    assert bool(np.all(np.diff(done.from_s) <= steps_s * (1 + 1e-6)))


def test_nothing_is_touched_where_nothing_is_needed() -> None:
    path = path_of(0.3 + 0.05 * np.sin(0.5 * 0.02 * np.arange(500))[:, None] * np.ones(3))
    done = retime(path, limits(), 1.0)
    assert done.path is path
    assert done.from_s is path.t_s
    assert done.note == ""


def test_only_the_fast_spot_is_slowed() -> None:
    path = one_fast_spot()
    done = retime(path, limits(), 1.0)
    rate = np.gradient(done.from_s, done.path.t_s)
    away = np.abs(done.from_s - 15.0) > 1.0
    np.testing.assert_allclose(rate[away], 1.0, atol=1e-3)
    assert rate.min() < 0.2
    assert path.t_s[-1] + 1.0 < done.path.t_s[-1] < path.t_s[-1] + 5.0
    assert "index_pip would move at 2" in done.note
    assert "into extension, 30 deg/s are allowed" in done.note
    assert "at 15.0 s of the take" in done.note
    assert f"one pass lasts {done.path.t_s[-1]:.1f} s instead of 30.0 s" in done.note


def test_direction_decides() -> None:
    path = one_fast_spot()
    closing = replace(path, q_rad=path.q_rad[::-1].copy())
    stretched = [retime(p, limits(), 1.0).path.t_s[-1] for p in (path, closing)]
    assert stretched[0] > stretched[1] + 0.5


def test_a_slower_prescription_needs_less_stretching() -> None:
    lengths = [retime(one_fast_spot(), limits(), speed).path.t_s[-1] for speed in (0.25, 0.5, 1.0)]
    assert lengths == sorted(lengths)
    assert lengths[0] < lengths[2] - 0.5


@pytest.mark.parametrize("path", [one_fast_spot(), restless(7), restless(8)])
def test_slowing_is_gentle(path: ReferencePath) -> None:
    done = retime(path, limits(), 1.0)
    before, after = QuinticPath(path), QuinticPath(done.path)
    before_s, after_s = instants(before.duration_s), instants(after.duration_s)
    for derivative in (2, 3):
        highest = np.abs(before.sample(before_s, derivative)).max()
        assert np.abs(after.sample(after_s, derivative)).max() < highest


def test_the_stretch_is_twice_continuously_differentiable() -> None:
    """Halving the step halves the largest step of the second derivative: a jump would stay."""
    jumps: list[float] = []
    for step_s in (0.002, 0.001):
        t_s = step_s * np.arange(round(3.0 / step_s))
        need = np.where(np.abs(t_s - 1.5) < 0.2, MOST, 0.5)
        bend = np.diff(np.log(stretch(need, step_s)), 2) / step_s**2
        jumps.append(float(np.abs(np.diff(bend)).max() / np.abs(bend).max()))
    assert jumps[1] < 0.6 * jumps[0] < 0.05


def test_the_stretch_meets_every_need() -> None:
    rng = np.random.default_rng(9)
    for _ in range(20):
        need = np.where(rng.random(800) < 0.02, rng.uniform(1.0, MOST, 800), rng.uniform(0.0, 1.0, 800))
        slow = stretch(need, 0.005)
        assert slow.shape == need.shape
        assert bool(np.all(slow >= np.maximum(need, 1.0) * (1 - 1e-12)))
        assert slow.max() <= need.max() * (1 + 1e-12)
    lone = np.zeros(800)
    lone[400] = 8.0
    slow = stretch(lone, 0.005)
    assert slow[400] == pytest.approx(8.0)
    np.testing.assert_array_equal(slow[np.abs(np.arange(800) - 400) * 0.005 > 0.32], 1.0)
    np.testing.assert_allclose(slow, slow[np.r_[0, np.arange(799, 0, -1)]], rtol=1e-12)


def test_what_slowing_cannot_mend_is_refused() -> None:
    with pytest.raises(Refused, match=r"index_pip at 15\.0 s of the take is moving at 2\d\d deg/s into ext"):
        retime(one_fast_spot(), limits(extension_deg_s=8.0), 1.0)
    retime(one_fast_spot(), limits(extension_deg_s=8.0), 0.5)
    for speed in (0.0, 1.5, float("nan")):
        with pytest.raises(Refused, match="at most 1"):
            retime(one_fast_spot(), limits(), speed)


RECORDINGS = ("mocap_hand_dfki/recording.tsv", "human_hand_video/landmarks_m.npz")


@pytest.fixture(scope="module", params=RECORDINGS)
def real(
    request: pytest.FixtureRequest, shared_data: Path, tmp_path_factory: pytest.TempPathFactory
) -> HandMotion:
    taken = import_recording(shared_data / request.param, "right")
    file = tmp_path_factory.mktemp("take") / "take.mcap"
    taken.write(file, exercise="real", software_version="0")
    with SessionReader(file) as reader:
        return read_motion(reader)


def build(take: HandMotion, bounds: Limits, speed: float | None) -> BuiltReference:
    return build_reference(
        take,
        patient_geometry=average_hand(),
        patient_side="right",
        driven_joints=capabilities("exoskeleton").joint_names,
        limits=bounds,
        take_digest="0" * 64,
        speed=speed,
    )


def test_real_takes_are_playable_for_spastic_hands(real: HandMotion) -> None:
    device = capabilities("exoskeleton")
    bounds = shipped_limits(device.joint_names, device.q_min_rad, device.q_max_rad, spastic=True)
    shown = build(real, bounds, None)
    assert shown.fastest_speed < 0.1
    for speed in (0.25, 0.5, 1.0):
        built = build(real, bounds, speed)
        assert built.fastest_speed >= speed * (1 - 1e-12)
        assert check_path(QuinticPath(built.path), bounds, speed, TICK_S) is None
        assert built.path.t_s[-1] / speed < 0.6 * shown.path.t_s[-1] / shown.fastest_speed
        assert built.notes[0].startswith("Slowed locally to keep the limits")
        assert built.residual_m == shown.residual_m
        from_s = built.take_t_s - built.take_start_s
        np.testing.assert_allclose(built.path.q_rad, QuinticPath(shown.path).sample(from_s), atol=1e-12)
    slow = build(real, bounds, 0.9 * shown.fastest_speed)
    np.testing.assert_array_equal(slow.path.q_rad, shown.path.q_rad)
    np.testing.assert_array_equal(slow.path.t_s, shown.path.t_s)
    assert slow.notes == shown.notes
