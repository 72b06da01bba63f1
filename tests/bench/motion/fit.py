"""Joint fit against its peer, filter then inverse kinematics, at its best of 2 to 8 Hz."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.signal import butter, filtfilt

from rehab_app.grasp.hand import GraspHand, human_hand
from rehab_app.grasp.spiral import inverse
from rehab_app.therapy.position_fit import fit_positions
from sessions.records import FINGERS, JOINTS
from sessions.records.fields import Float64
from tests.bench.motion.fit_movements import MOVEMENTS, Drawn, draw

NOISES_M = (1e-3, 2e-3, 3e-3)
SEEDS = (201, 202, 203, 204, 205)
"""Never tuned on."""
CUTOFFS_HZ = (2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0)

_WINDOW = 3
_HAMPEL = 4.0
_FLEXIONS = np.array(
    [JOINTS.index(f"{finger}_{joint}") for finger in FINGERS for joint in ("mcp_flexion", "pip")]
)


@dataclass(frozen=True, slots=True)
class FitRow:
    """One movement at one noise, over all seeds.

    Attributes:
        seen: "fingertips" or "landmarks".
        movement: Its name.
        noise_m: Standard deviation of a position per axis.
        fit_rad: Flexion error of the joint fit, rms over MCP and PIP of the long fingers.
        peer_rad: That of filter-then-IK with the cutoff that is best for this very movement and noise.
        cutoff_hz: That cutoff.
        fit_ms: Median processor time of a fit of 12 s.
    """

    seen: str
    movement: str
    noise_m: float
    fit_rad: float
    peer_rad: float
    cutoff_hz: float
    fit_ms: float

    @property
    def ratio(self) -> float:
        """Error of the fit over that of its peer."""
        return self.fit_rad / self.peer_rad


def fit_table(
    seeds: tuple[int, ...] = SEEDS,
    rate_hz: float = 30.0,
    sights: tuple[str, ...] = ("fingertips", "landmarks"),
) -> list[FitRow]:
    """All movements, noises and sights."""
    return [
        fit_row(seen, movement, noise_m, seeds, rate_hz)
        for seen in sights
        for noise_m in NOISES_M
        for movement in MOVEMENTS
    ]


def fit_row(
    seen: str, movement: str, noise_m: float, seeds: tuple[int, ...] = SEEDS, rate_hz: float = 30.0
) -> FitRow:
    """One movement at one noise."""
    fits, times = [], []
    peers: list[list[float]] = [[] for _ in CUTOFFS_HZ]
    for seed in seeds:
        drawn = draw(movement, noise_m, seed, rate_hz, tips_only=seen == "fingertips")
        begun = time.process_time()
        fitted = fit_positions(drawn.t_s, drawn.seen_m, drawn.geometry, _grid(drawn.t_s)).joints_rad
        times.append(1e3 * (time.process_time() - begun))
        at_samples = np.stack(
            [np.interp(drawn.t_s, _grid(drawn.t_s), fitted[:, joint]) for joint in _FLEXIONS], axis=1
        )
        fits.append(_square(at_samples - drawn.joints_rad[:, _FLEXIONS]))
        for which, cutoff_hz in enumerate(CUTOFFS_HZ):
            inverse_rad = filter_then_inverse(drawn, cutoff_hz)
            peers[which].append(_square(inverse_rad - drawn.joints_rad[:, _FLEXIONS]))
    best = int(np.argmin([np.mean(one) for one in peers]))
    return FitRow(
        seen,
        movement,
        noise_m,
        float(np.sqrt(np.mean(fits))),
        float(np.sqrt(np.mean(peers[best]))),
        CUTOFFS_HZ[best],
        float(np.median(times)),
    )


def filter_then_inverse(drawn: Drawn, cutoff_hz: float) -> Float64:
    """MCP and PIP of the long fingers, each posture by itself, from filtered positions, shape (N, 8)."""
    rate_hz = 1.0 / float(drawn.t_s[1] - drawn.t_s[0])
    tracks: list[Float64] = []
    for number in range(len(FINGERS)):
        seen_m = drawn.seen_m[:, [4 * (number + 1) + part for part in (1, 2, 3)]]
        shown = [mark for mark in range(3) if np.isfinite(seen_m[:, mark]).any()]
        clean = np.stack([filtered(seen_m[:, mark], cutoff_hz, rate_hz) for mark in shown], axis=1)
        tracks.append(clean - drawn.geometry.bases_m[number + 1])
    if tracks[0].shape[1] == 1:
        return _tip_inverse(human_hand(drawn.geometry), np.concatenate(tracks, axis=1))
    return np.concatenate([_bone_angles(track) for track in tracks], axis=1)


def filtered(seen_m: Float64, cutoff_hz: float, rate_hz: float) -> Float64:
    """One marker's track (N, 3): Hampel, gaps bridged, zero-phase Butterworth of fourth order."""
    rows = np.arange(len(seen_m))
    known = np.flatnonzero(np.isfinite(seen_m).all(axis=1))
    shown = seen_m[known]
    windows = np.lib.stride_tricks.sliding_window_view(
        np.pad(shown, ((_WINDOW, _WINDOW), (0, 0)), mode="edge"), 2 * _WINDOW + 1, axis=0
    )
    middle = np.median(windows, axis=-1)
    spread = 1.4826 * np.median(np.abs(windows - middle[..., None]), axis=-1)
    good = (np.abs(shown - middle) <= _HAMPEL * spread).all(axis=1)
    calm = np.stack([np.interp(rows, known[good], shown[good, axis]) for axis in range(3)], axis=1)
    designed: Any = butter(2, cutoff_hz, fs=rate_hz)
    numerator, denominator = designed
    clean: Float64 = filtfilt(numerator, denominator, calm, axis=0)
    return clean


def _tip_inverse(hand: GraspHand, tips_m: Float64) -> Float64:
    """MCP and PIP (N, 8) of fingers whose DIP follows, from their tips beyond their bases (N, 4, 3)."""
    distal = np.where(tips_m[..., 2] < 0.0, -1.0, 1.0) * np.hypot(tips_m[..., 1], tips_m[..., 2])
    plane = np.stack([distal, tips_m[..., 0]], axis=-1)
    far = np.linalg.norm(plane, axis=-1)
    bent = np.cumsum([0.0, hand.pip_max_rad, hand.dip_per_pip * hand.pip_max_rad])
    least = np.hypot(hand.links_m @ np.cos(bent), hand.links_m @ np.sin(bent))
    plane *= (np.clip(far, least, hand.links_m.sum(axis=1)) / far)[..., None]
    mcp, pip = inverse(hand, plane)
    return np.stack([mcp, pip], axis=-1).reshape(len(mcp), -1)


def _bone_angles(marks_m: Float64) -> Float64:
    """MCP and PIP (N, 2) from the directions of a finger's bones; PIP, DIP and tip beyond its base."""
    bones = np.diff(marks_m, axis=1, prepend=np.zeros((len(marks_m), 1, 3)))
    abduction = np.arctan2(marks_m[:, 0, 1], marks_m[:, 0, 2])
    abduction = np.clip(abduction, -0.4, 0.4)
    distal = np.cos(abduction)[:, None] * bones[..., 2] + np.sin(abduction)[:, None] * bones[..., 1]
    turned = np.unwrap(np.arctan2(bones[..., 0], distal), axis=1)
    return np.stack([turned[:, 0], turned[:, 1] - turned[:, 0]], axis=1)


def _grid(t_s: Float64) -> Float64:
    return np.linspace(t_s[0], t_s[-1], int(np.ceil((t_s[-1] - t_s[0]) / 0.02)) + 1)


def _square(error_rad: Float64) -> float:
    return float(np.mean(error_rad**2))
