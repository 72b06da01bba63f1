"""TLS by certificate files: refused in a sentence, cookies that insist on it, HSTS."""

from __future__ import annotations

import http.client
import ssl
import threading
from datetime import UTC, datetime, timedelta

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

from rehab_app.errors import Refused
from rehab_app.web import create_app
from rehab_app.web.server import ShellServer, listen
from rehab_app.web.tls import tls_files

from .conftest import PASSWORD, NoPictures


def written(folder, name, days=30, passphrase=b""):
    """A self-made certificate for localhost and its key."""
    key = ec.generate_private_key(ec.SECP256R1())
    person = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "localhost")])
    now = datetime.now(UTC)
    certificate = (
        x509.CertificateBuilder()
        .subject_name(person)
        .issuer_name(person)
        .public_key(key.public_key())
        .serial_number(1)
        .not_valid_before(now - timedelta(days=60))
        .not_valid_after(now + timedelta(days=days))
        .add_extension(x509.SubjectAlternativeName([x509.DNSName("localhost")]), critical=False)
        .sign(key, hashes.SHA256())
    )
    lock = serialization.BestAvailableEncryption(passphrase) if passphrase else serialization.NoEncryption()
    pem, form = serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8
    (folder / f"{name}.pem").write_bytes(certificate.public_bytes(pem))
    (folder / f"{name}.key").write_bytes(key.private_bytes(pem, form, lock))
    return folder / f"{name}.pem", folder / f"{name}.key"


def test_none_is_wanted():
    assert tls_files(None, None) is None


def test_both_are_needed_readable_and_of_one_pair(tmp_path):
    certificate, key = written(tmp_path, "one")
    _, other = written(tmp_path, "two")
    _, locked = written(tmp_path, "three", passphrase=b"secret")
    nonsense = tmp_path / "nonsense.pem"
    nonsense.write_text("no certificate")
    for pair, sentence in (
        ((certificate, None), "TLS key is not given"),
        ((None, key), "TLS certificate is not given"),
        ((tmp_path / "none.pem", key), "TLS certificate is none.pem, not readable"),
        ((certificate, tmp_path), "TLS key is .*not readable"),
        ((certificate, other), "not usable together"),
        ((nonsense, key), "not usable together"),
        ((certificate, locked), "not usable together"),
    ):
        with pytest.raises(Refused, match=sentence):
            tls_files(*pair)


@pytest.mark.parametrize(("days", "words"), [(30, ""), (3, "expires in"), (-3, "expired on")])
def test_an_old_certificate_is_a_warning(tmp_path, days, words):
    found = tls_files(*written(tmp_path, "one", days))
    assert words in found.warning
    assert bool(found.warning) == bool(words)


@pytest.fixture
def line(clinic, tmp_path):
    """A connection to the clinic over TLS, its certificate checked."""
    files = tls_files(*written(tmp_path, "one"))
    door, ready = listen("127.0.0.1", 0), threading.Event()
    server = ShellServer(create_app(clinic, open_viewports=lambda _: NoPictures()), ready.set, files)
    thread = threading.Thread(target=server.run, kwargs={"sockets": [door]})
    thread.start()
    assert ready.wait(20)
    trusted = ssl.create_default_context(cafile=files.certificate)
    connection = http.client.HTTPSConnection("localhost", door.getsockname()[1], context=trusted, timeout=10)
    yield connection
    connection.close()
    server.should_exit = True
    thread.join()
    door.close()


def test_over_tls_cookies_insist_on_it_and_the_browser_is_told_to_stay(line):
    body = f"name=therapist&password={PASSWORD.replace(' ', '+')}"
    headers = {
        "origin": f"https://localhost:{line.port}",
        "content-type": "application/x-www-form-urlencoded",
    }
    line.request("POST", "/sign-in", body, headers)
    answer = line.getresponse()
    answer.read()
    assert answer.status == 303
    cookie = answer.headers["set-cookie"].lower()
    assert "; secure" in cookie
    assert "httponly" in cookie
    assert "samesite=strict" in cookie
    assert answer.headers["strict-transport-security"] == "max-age=2592000"
    line.request("POST", "/sign-in", body, {**headers, "origin": f"http://localhost:{line.port}"})
    refused = line.getresponse()
    refused.read()
    assert refused.status == 403


def test_plain_http_says_nothing_of_tls(browser):
    assert "strict-transport-security" not in browser().get("/sign-in").headers
