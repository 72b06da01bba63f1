"""What a browser is allowed to do with each kind of page."""

from __future__ import annotations

from collections.abc import Sequence

SHELL = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; font-src 'self'; "
    "connect-src 'self'; frame-src 'self'; worker-src 'self'; form-action 'self'; base-uri 'none'; "
    "frame-ancestors 'none'"
)
# A report is one self-contained file: no script may run in it, and it may print.
REPORT = (
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; font-src data:; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'self'; sandbox allow-same-origin allow-modals"
)
ALWAYS = {
    "x-content-type-options": "nosniff",
    "referrer-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "permissions-policy": "camera=(), microphone=(), geolocation=(), usb=(), serial=()",
}
# Sent over TLS only: for a month, browsers do not ask this name over plain HTTP again.
TRANSPORT = ("strict-transport-security", "max-age=2592000")
DEFAULTS = {"content-security-policy": SHELL, "x-frame-options": "DENY", "cache-control": "no-store"}


def viewport_policy(script_hashes: Sequence[str]) -> str:
    """Policy of the viewport's page: only its own two scripts run, and it talks only to this server.

    Args:
        script_hashes: Such as ``sha256-...``; inline scripts with another content are refused, which is what
            keeps HTML that reached the viewport from running.
    """
    scripts = " ".join(f"'{digest}'" for digest in script_hashes)
    return (
        f"default-src 'none'; script-src {scripts} 'wasm-unsafe-eval'; style-src 'self' 'unsafe-inline'; "
        "img-src 'self' data: blob:; font-src data:; connect-src 'self' data: blob:; worker-src blob: data:; "
        "base-uri 'none'; form-action 'none'; frame-ancestors 'self'"
    )
