"""Hashes by the system's sha256sum, signatures by the system's OpenSSL."""

import shutil
import subprocess
from pathlib import Path

import pytest

pytest.importorskip("cryptography")

from reflexarc.securing.policy_keys import make_key, sign_file
from reflexarc_runtime.errors import PolicyError, UsageError
from reflexarc_runtime.policy.acceptance import Acceptance, signature_path

POLICY = b"\x08\x07 any bytes \x00\xff"

needs_openssl = pytest.mark.skipif(shutil.which("openssl") is None, reason="no openssl here")


@pytest.fixture
def policy(tmp_path: Path) -> Path:
    path = tmp_path / "policy.onnx"
    path.write_bytes(POLICY)
    return path


def openssl(*words: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(["openssl", *map(str, words)], capture_output=True, text=True)


def test_the_file_of_the_hash_is_accepted_and_one_of_another_bit_is_not(policy: Path):
    told = subprocess.run(["sha256sum", policy], capture_output=True, text=True, check=True)
    acceptance = Acceptance(sha256=told.stdout.split()[0])
    assert acceptance.accept_file(policy) == POLICY
    with pytest.raises(PolicyError, match="--expect-hash"):
        acceptance.accept(POLICY[:-1] + b"\xfe")


@pytest.mark.parametrize("digits", ["", "abc", "0" * 63, "g" * 64, "0" * 65])
def test_what_is_no_hash_is_refused(digits: str):
    with pytest.raises(UsageError, match="64 digits"):
        Acceptance(sha256=digits)


def test_nothing_asked_for_accepts_anything():
    Acceptance().accept(b"anything")


def test_a_signature_is_of_every_bit_and_of_one_key(policy: Path, tmp_path: Path):
    public = make_key(tmp_path / "mine.key")
    signature = sign_file(policy, tmp_path / "mine.key").read_bytes()
    acceptance = Acceptance(public_key=public.read_bytes())
    assert acceptance.accept_file(policy) == POLICY
    acceptance.accept(POLICY, signature)
    for bad, words in ((POLICY + b"\x00", signature), (POLICY, signature[:-1]), (POLICY, b"")):
        with pytest.raises(PolicyError, match="--require-signature"):
            acceptance.accept(bad, words)
    other = make_key(tmp_path / "other.key")
    with pytest.raises(PolicyError, match=r"policy\.onnx"):
        Acceptance(public_key=other.read_bytes()).accept_file(policy)


def test_a_missing_signature_is_told_from_a_wrong_one(policy: Path, tmp_path: Path):
    public = make_key(tmp_path / "mine.key")
    with pytest.raises(PolicyError, match=r"policy\.onnx\.sig.*found none"):
        Acceptance(public_key=public.read_bytes()).accept_file(policy)


def test_what_has_no_end_is_not_read_to_it(policy: Path, tmp_path: Path):
    acceptance = Acceptance(public_key=make_key(tmp_path / "mine.key").read_bytes())
    with pytest.raises(PolicyError, match="at most 64 MiB"):
        acceptance.accept_file(Path("/dev/zero"))
    signature_path(policy).symlink_to("/dev/zero")
    with pytest.raises(PolicyError, match="expected the 64 raw bytes of a signature, got more"):
        acceptance.accept_file(policy)


@needs_openssl
def test_openssl_verifies_what_we_signed(policy: Path, tmp_path: Path):
    public = make_key(tmp_path / "mine.key")
    signature = sign_file(policy, tmp_path / "mine.key")
    words = ("-verify", "-rawin", "-pubin", "-inkey", public, "-sigfile", signature)
    assert openssl("pkeyutl", *words, "-in", policy).returncode == 0
    policy.write_bytes(POLICY + b"!")
    assert openssl("pkeyutl", *words, "-in", policy).returncode != 0


@needs_openssl
def test_we_accept_what_openssl_made_and_signed(policy: Path, tmp_path: Path):
    secret, public = tmp_path / "its.key", tmp_path / "its.pub"
    assert openssl("genpkey", "-algorithm", "ed25519", "-out", secret).returncode == 0
    assert openssl("pkey", "-in", secret, "-pubout", "-out", public).returncode == 0
    signature = signature_path(policy)
    signed = openssl(
        "pkeyutl", "-sign", "-rawin", "-inkey", secret, "-in", policy, "-out", signature
    )
    assert signed.returncode == 0
    assert Acceptance(public_key=public.read_bytes()).accept_file(policy) == POLICY
    theirs = signature.read_bytes()  # Ed25519 is deterministic: both sign alike
    assert sign_file(policy, secret).read_bytes() == theirs


@needs_openssl
def test_keys_of_another_kind_are_refused(policy: Path, tmp_path: Path):
    secret, public = tmp_path / "ec.key", tmp_path / "ec.pub"
    openssl("ecparam", "-genkey", "-name", "prime256v1", "-noout", "-out", secret)
    openssl("pkey", "-in", secret, "-pubout", "-out", public)
    with pytest.raises(UsageError, match="Ed25519"):
        sign_file(policy, secret)
    with pytest.raises(UsageError, match="Ed25519"):
        Acceptance(public_key=public.read_bytes()).accept(POLICY, bytes(64))
    for none in (b"none", b""):
        with pytest.raises(UsageError, match="not a public key"):
            Acceptance(public_key=none)


def test_keys_are_secret_and_never_overwritten(tmp_path: Path):
    public = make_key(tmp_path / "mine.key")
    assert (tmp_path / "mine.key").stat().st_mode & 0o077 == 0
    before = public.read_bytes()
    with pytest.raises(UsageError, match="nothing is overwritten"):
        make_key(tmp_path / "mine.key")
    assert public.read_bytes() == before
