"""Canonical bytes and digests: what a certificate is for, and what a run recorded.

Bytes depend on values alone (field names, little-endian numbers, shapes), never on addresses, platforms or
the order of a dictionary, so that equal things have equal digests everywhere.
"""

from __future__ import annotations

import hashlib
import struct
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np

from robot_iface.errors import Refused
from robot_iface.types import Certificate, Plan

PARTS: tuple[str, ...] = (
    *("path", "sweep", "prescription", "limits", "twin", "device", "software_version", "wrist_rad"),
)
"""The parts of a plan that a rehearsal depends on. Seed, pace and scripted stops are not among them."""


def canonical_bytes(value: Any) -> bytes:
    """Bytes of a value of this package's types, the same wherever it is computed.

    Raises:
        TypeError: The value holds something that has no canonical form.
    """
    if value is None:
        return b"none;"
    if isinstance(value, np.ndarray):
        array: Any = np.ascontiguousarray(value)
        little = array.astype(array.dtype.newbyteorder("<"), copy=False)
        return f"array{array.dtype.kind}{array.dtype.itemsize}{array.shape}".encode() + little.tobytes()
    if is_dataclass(value):
        parts = [entry.name.encode() + canonical_bytes(getattr(value, entry.name)) for entry in fields(value)]
        return type(value).__name__.encode() + b"{" + b"".join(parts) + b"}"
    if isinstance(value, str):
        text = value.encode()
        return f"text{len(text)}:".encode() + text
    if isinstance(value, bool | int | np.integer):
        return f"int{int(value)};".encode()
    if isinstance(value, float):
        return b"real" + struct.pack("<d", value)
    if isinstance(value, tuple):
        return f"tuple{len(value)}(".encode() + b"".join(canonical_bytes(item) for item in value) + b")"
    raise TypeError(f"{type(value).__name__} has no canonical form")


def plan_parts(plan: Plan) -> tuple[str, ...]:
    """One ``name:SHA-256`` for each of PARTS."""
    return tuple(f"{name}:{_sha256(canonical_bytes(getattr(plan, name)))}" for name in PARTS)


def seal(certificate: Certificate) -> Certificate:
    """The certificate with its digest: over the plan's parts and everything that the rehearsal found."""
    return replace(certificate, digest=_sha256(canonical_bytes(replace(certificate, digest=""))))


def check_certificate(plan: Plan, certificate: Certificate) -> None:
    """Let a plan pass only with the accepted, untouched certificate of its own rehearsal.

    Raises:
        Refused: The certificate was altered, is for another plan (the sentence names what differs), or was
            not accepted.
    """
    if seal(certificate).digest != certificate.digest:
        raise Refused(
            "rehearsal certificate", "altered since the rehearsal", "as it was issued", "rehearse again"
        )
    if certificate.parts != plan_parts(plan):
        issued = set(certificate.parts)
        other = [_spoken(part) for part in plan_parts(plan) if part not in issued]
        raise Refused(
            "rehearsal certificate",
            "for a different " + " and ".join(other or ["plan"]),
            "for exactly the plan that is to run",
            "rehearse this plan",
        )
    if not certificate.accepted:
        raise Refused(
            "rehearsal",
            f"not accepted ({certificate.summary})",
            "accepted",
            "change the plan and rehearse again",
        )


def _spoken(part: str) -> str:
    """The name of a part as a person reads it."""
    return part.split(":", 1)[0].replace("_rad", " angle").replace("_", " ")


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
