"""Past sessions made up for tests of progress."""

from __future__ import annotations

import math
from typing import Any

from sessions.reports.past import Kept, Past, Trial
from sessions.reports.progress import Progress

DAY_NS = 86_400_000_000_000


def kept(name: str, subject: str, value: float | None, half: float = 0.01, **changes: Any) -> Kept:
    ends = (None, None) if value is None else (value - half, value + half)
    fields = {
        "status": "ok" if value is not None else "not measurable: unseen",
        "version": "1",
        "source": "encoder",
    }
    return Kept(name, subject, value, *ends, **{**fields, **changes})


def past(number: int, *, pip_deg: float | None = 40.0, stiffness: float = 0.9, **changes: Any) -> Past:
    """Session ``number`` of days: the index PIP's range, an error, a dose."""
    numbers = (
        kept("range_of_motion", "index_pip", None if pip_deg is None else math.radians(pip_deg)),
        kept("fingertip_rmse", "index", 0.009, 0.001),
        kept("joint_rmse", "whole", 0.05, 0.005),
        kept("stiffness", "index_pip", stiffness),
        kept("repetitions", "whole", 6.0),
        kept("repetitions_by_patient", "whole", float(min(number + 1, 6))),
        kept("dose_time", "whole", 120.0),
    )
    fields: dict[str, Any] = {
        "session_id": f"s{number}",
        "sha256": f"{number:064x}",
        "subject_id": "P-0001",
        "utc_start_ns": 1_790_000_000_000_000_000 + number * DAY_NS,
        "side": "right",
        "exercise": "open_close",
        "modes": ("assistive",),
        "conditions": f"stiffness {stiffness:.2f} Nm/rad, assistive mode",
        "numbers": numbers,
        "trials": tuple(Trial(index, True, "patient", ()) for index in range(6)),
    }
    return Past(**{**fields, **changes})


def progress(*pasts: Past, **changes: Any) -> Progress:
    fields: dict[str, Any] = {
        "subject_id": "P-0001",
        "side": "right",
        "pasts": pasts,
        "left_out": (),
        "scores": (),
        "pains": (),
        "bounds": (),
        "ordered": 0,
        "software_version": "0.1.0",
    }
    return Progress(**{**fields, **changes})
