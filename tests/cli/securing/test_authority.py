"""Certificates, as the system's OpenSSL sees them."""

import shutil
import subprocess
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

pytest.importorskip("cryptography")

from cryptography import x509

from reflexarc.securing.authority import Authority, Identity, Validity

pytestmark = pytest.mark.skipif(shutil.which("openssl") is None, reason="no openssl here")

AUTHORITY = Authority.made("authority", Validity.of_days(10))
HOSTS = ("10.0.0.1", "rover1.local", "::1")


def verified(folder: Path, own: Identity, *words: str, by: Authority = AUTHORITY) -> bool:
    known, file = folder / "ca.pem", folder / "own.pem"
    known.write_bytes(by.identity.certificate)
    file.write_bytes(own.certificate)
    done = subprocess.run(
        ["openssl", "verify", "-x509_strict", "-CAfile", known, *words, file], capture_output=True
    )
    return done.returncode == 0


def test_a_door_is_one_at_its_own_names_alone(tmp_path: Path):
    door = AUTHORITY.issue("body.robot0", Validity.of_days(1), HOSTS)
    assert verified(tmp_path, door, "-purpose", "sslserver", "-verify_ip", "10.0.0.1")
    assert verified(tmp_path, door, "-purpose", "sslserver", "-verify_hostname", "rover1.local")
    assert not verified(tmp_path, door, "-purpose", "sslserver", "-verify_ip", "10.0.0.2")
    assert not verified(tmp_path, door, "-verify_hostname", "body.robot0")


def test_a_guest_is_no_door_and_no_authority(tmp_path: Path):
    guest = AUTHORITY.issue("runtime.robot0", Validity.of_days(1))
    assert verified(tmp_path, guest, "-purpose", "sslclient")
    assert not verified(tmp_path, guest, "-purpose", "sslserver")
    false_authority = Authority.of_pem(guest.certificate, guest.key)
    made = false_authority.issue("operator.robot0", Validity.of_days(1))
    chain = tmp_path / "guest.pem"
    chain.write_bytes(guest.certificate)
    assert not verified(tmp_path, made, "-untrusted", str(chain))


def test_another_authority_of_the_same_name_is_another_one(tmp_path: Path):
    namesake = Authority.made("authority", Validity.of_days(10))
    assert not verified(tmp_path, namesake.issue("body.robot0", Validity.of_days(1)))


def test_a_certificate_holds_from_a_little_before_to_its_end(tmp_path: Path):
    own = AUTHORITY.issue("runtime.robot0", Validity.of_days(2))
    now = datetime.now(UTC)
    ages = {timedelta(days=1): True, timedelta(days=3): False, timedelta(hours=-2): False}
    for later, holds in ages.items():
        when = str(int((now + later).timestamp()))
        assert verified(tmp_path, own, "-attime", when) is holds
    assert verified(tmp_path, own)


def test_an_authority_that_was_kept_signs_as_before(tmp_path: Path):
    kept = Authority.of_pem(AUTHORITY.identity.certificate, AUTHORITY.identity.key)
    assert verified(tmp_path, kept.issue("viewer.robot0", Validity.of_days(1)))


def test_keys_of_a_role_are_new_each_time():
    one, two = (AUTHORITY.issue("viewer.robot0", Validity.of_days(1)) for _ in range(2))
    assert one.key != two.key
    certificates = [x509.load_pem_x509_certificate(each.certificate) for each in (one, two)]
    assert certificates[0].serial_number != certificates[1].serial_number
