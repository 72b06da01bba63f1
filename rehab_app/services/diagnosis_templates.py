"""Diagnosis templates: what may be done with a hand, and from which day on.

Every number here is a proposal [P] that a clinician of the clinic must sign: it ships as a default, is shown,
and a therapist may unlock a mode earlier by a named act. Sources: the limits and hazards of the project's
clinical notes; days are the cautious end of common protocols (tendon: protected passive motion from
day 3, no active or resisted motion before weeks 6 and 8; fracture: no stretch or resistance before union).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from robot_iface.types import Mode

SKIN_CHECK_S = 600.0
"""Motion time after which a person must have looked at skin that does not warn (hazard 9)."""
BY_ACT_ONLY = math.inf
"""Day of a mode that no date opens, only a therapist's named act."""


@dataclass(frozen=True, slots=True)
class Lock:
    """A mode that is closed at first.

    Attributes:
        mode: Therapy mode.
        from_day: First day on which it is open, counted from the event; BY_ACT_ONLY for never by itself.
        why: What it protects, in a few words.
    """

    mode: Mode
    from_day: float
    why: str


@dataclass(frozen=True, slots=True)
class Template:
    """What a diagnosis means for therapy on the robot; modes without a lock are open at once.

    Attributes:
        key: How records and the command line name it.
        words: How a person reads it.
        event: What the event date is the date of; empty where no date matters.
        locks: Modes that are closed at first.
        halved: Whether torque limits are halved.
        spastic: Whether the fingers count as spastic as long as nobody has graded them.
        skin_check_s: Motion time between looks at the skin, 0 for none.
        own_range_until_day: Before this day the shipped full range is refused: a person must have measured
            or set the range today.
    """

    key: str
    words: str
    event: str = ""
    locks: tuple[Lock, ...] = ()
    halved: bool = False
    spastic: bool = False
    skin_check_s: float = 0.0
    own_range_until_day: float = 0.0


def _weeks(number: float) -> float:
    return 7.0 * number


_TENDON = "the repaired tendon"
_CALLUS = "the healing bone"

TEMPLATES: tuple[Template, ...] = (
    Template("none", "no diagnosis"),
    Template(
        "stroke",
        "stroke",
        "stroke",
        (
            Lock("passive", 1, "the first day"),
            Lock("assistive", 1, "the first day"),
            Lock("transparent", 1, "the first day"),
            Lock("resistive", _weeks(2), "tone that is still changing"),
        ),
        spastic=True,
    ),
    Template(
        "flexor-tendon-repair",
        "flexor tendon repair",
        "operation",
        (
            Lock("passive", 3, _TENDON),
            Lock("assistive", _weeks(6), _TENDON),
            Lock("transparent", _weeks(6), _TENDON),
            Lock("resistive", _weeks(8), _TENDON),
        ),
        own_range_until_day=_weeks(8),
    ),
    Template(
        "extensor-tendon-repair",
        "extensor tendon repair",
        "operation",
        (
            Lock("transparent", _weeks(4), _TENDON),
            Lock("passive", _weeks(6), "the repaired tendon, which passive flexion stretches"),
            Lock("assistive", _weeks(6), "the repaired tendon, which assisted flexion stretches"),
            Lock("resistive", _weeks(8), _TENDON),
        ),
        own_range_until_day=_weeks(8),
    ),
    Template(
        "fracture",
        "fracture",
        "injury or operation",
        (
            Lock("transparent", _weeks(3), _CALLUS),
            Lock("assistive", _weeks(4), _CALLUS),
            Lock("passive", _weeks(6), _CALLUS),
            Lock("resistive", _weeks(8), _CALLUS),
        ),
        own_range_until_day=_weeks(8),
    ),
    Template(
        "rheumatoid-arthritis",
        "rheumatoid arthritis",
        locks=(Lock("resistive", BY_ACT_ONLY, "inflamed joints"),),
        halved=True,
    ),
    Template(
        "crps",
        "complex regional pain syndrome",
        locks=(
            Lock("passive", BY_ACT_ONLY, "a hand that forced movement inflames"),
            Lock("resistive", BY_ACT_ONLY, "a hand that load inflames"),
        ),
        halved=True,
    ),
    Template(
        "nerve-lesion",
        "nerve lesion",
        "injury or operation",
        (
            Lock("passive", _weeks(3), "the sutured nerve"),
            Lock("assistive", _weeks(3), "the sutured nerve"),
            Lock("transparent", _weeks(3), "the sutured nerve"),
            Lock("resistive", _weeks(8), "the sutured nerve"),
        ),
        halved=True,
        skin_check_s=SKIN_CHECK_S,
    ),
    Template(
        "burn",
        "burn or contracture of the skin",
        "injury or operation",
        (
            Lock("transparent", 5, "fresh grafts"),
            Lock("assistive", 7, "fresh grafts"),
            Lock("passive", 7, "fresh grafts"),
            Lock("resistive", _weeks(6), "grafts and scars"),
        ),
        halved=True,
        skin_check_s=SKIN_CHECK_S,
        own_range_until_day=_weeks(6),
    ),
)
KEYS: tuple[str, ...] = tuple(template.key for template in TEMPLATES)
