"""TLS by certificate files: refused before anything listens where they cannot serve."""

from __future__ import annotations

import ssl
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from cryptography import x509

from rehab_app.errors import Refused

_SOON_DAYS = 14


@dataclass(frozen=True, slots=True)
class TlsFiles:
    """A certificate chain and its key, both PEM.

    Attributes:
        certificate: The chain, own certificate first.
        key: The private key, without a passphrase.
        warning: What a person should know, "" where all is well.
    """

    certificate: Path
    key: Path
    warning: str = ""


def tls_files(certificate: Path | None, key: Path | None) -> TlsFiles | None:
    """The files to serve with, tried out; None where TLS is not wanted.

    Raises:
        Refused: One of the two is missing or unreadable, or they do not belong together.
    """
    if certificate is None and key is None:
        return None
    if certificate is None or key is None:
        absent = "certificate" if certificate is None else "key"
        raise Refused(f"TLS {absent}", "not given", "a PEM file", "give both --tls-cert and --tls-key")
    for what, path in (("certificate", certificate), ("key", key)):
        _check_readable(f"TLS {what}", path)
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    try:
        context.load_cert_chain(certificate, key, password=_no_passphrase)
    except (ssl.SSLError, ValueError) as error:
        reason = getattr(error, "reason", None) or str(error)
        value = f"not usable together ({str(reason).replace('_', ' ').lower()})"
        bound = "PEM files of one pair, the key without a passphrase"
        raise Refused("TLS certificate and key", value, bound, "check both files") from error
    return TlsFiles(certificate, key, _warning(certificate))


def _check_readable(thing: str, path: Path) -> None:
    try:
        with path.open("rb") as file:
            file.read(1)
    except OSError as error:
        value = f"{path.name}, not readable ({error.strerror or error})"
        raise Refused(thing, value, "a PEM file that can be read", "check the path and its rights") from error


def _no_passphrase() -> str:
    """Asked by OpenSSL where the key is encrypted: a server that starts by itself has nobody to ask."""
    raise ValueError("the key is encrypted")


def _warning(certificate: Path) -> str:
    now = datetime.now(UTC)
    own = x509.load_pem_x509_certificate(certificate.read_bytes())
    if own.not_valid_after_utc <= now:
        return f"The TLS certificate expired on {own.not_valid_after_utc:%Y-%m-%d}: browsers will warn."
    if own.not_valid_before_utc > now:
        return f"The TLS certificate holds from {own.not_valid_before_utc:%Y-%m-%d} only: browsers will warn."
    days = (own.not_valid_after_utc - now).days
    return f"The TLS certificate expires in {days} days." if days < _SOON_DAYS else ""
