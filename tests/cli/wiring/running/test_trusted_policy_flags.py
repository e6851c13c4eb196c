"""A policy that was accepted is the one that is loaded."""

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from reflexarc.wiring.running.trusted_policy_flags import TrustedPolicyFlags
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import PolicyError, UsageError
from reflexarc_runtime.policy.acceptance import signature_beside
from support.policies import exported

if TYPE_CHECKING:
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey


MINE, OTHER = exported(PolicyContract(), seed=5), exported(PolicyContract(), seed=6)


def test_a_hash_is_of_one_file_and_without_the_flags_any_is_taken(tmp_path: Path):
    path = tmp_path / "policy.onnx"
    flags = TrustedPolicyFlags(expect_hash=hashlib.sha256(MINE).hexdigest().upper())
    path.write_bytes(MINE)
    assert flags.check_file(path) == TrustedPolicyFlags().check_file(path) == MINE
    path.write_bytes(OTHER)
    assert TrustedPolicyFlags().check_file(path) == OTHER
    with pytest.raises(PolicyError, match="--expect-hash"):
        flags.check_file(path)


@pytest.mark.parametrize(
    "content", [b"", b"\n", b"x" * (1 << 17), None], ids=["empty", "line", "large", "endless"]
)
def test_a_key_that_is_none_is_refused_and_asks_for_no_less(content: bytes | None, tmp_path: Path):
    """An interrupted copy, /dev/null, a file without an end: each is a key that nobody has."""
    pytest.importorskip("cryptography")
    key = tmp_path / "mine.pub"
    if content is None:
        key.symlink_to("/dev/zero")
    else:
        key.write_bytes(content)
    with pytest.raises(UsageError, match="--require-signature"):
        TrustedPolicyFlags(require_signature=key).check()
    with pytest.raises(UsageError, match="--require-signature"):
        TrustedPolicyFlags(require_signature=Path("/dev/null")).refuses()


def test_a_hash_that_is_empty_is_refused():
    """What a script says whose variable is not set."""
    with pytest.raises(UsageError, match="--expect-hash: expected a SHA-256"):
        TrustedPolicyFlags(expect_hash="").check()


@pytest.fixture
def signing(tmp_path: Path) -> "Ed25519PrivateKey":
    """Whose signature is asked for; the public half is in `mine.pub`, as another library has it."""
    ed25519 = pytest.importorskip("cryptography.hazmat.primitives.asymmetric.ed25519")
    serialization = pytest.importorskip("cryptography.hazmat.primitives.serialization")
    private: Ed25519PrivateKey = ed25519.Ed25519PrivateKey.generate()
    pem = private.public_key().public_bytes(
        serialization.Encoding.PEM, serialization.PublicFormat.SubjectPublicKeyInfo
    )
    (tmp_path / "mine.pub").write_bytes(pem)
    return private


def test_what_comes_over_the_bus_is_taken_with_its_own_signature_alone(
    signing: "Ed25519PrivateKey", tmp_path: Path
):
    refusal_of = TrustedPolicyFlags(require_signature=tmp_path / "mine.pub").refuses()
    assert refusal_of(MINE, signing.sign(MINE)) == ""
    assert "got none: `reflexarc secure sign`" in refusal_of(MINE, b"")
    assert "somebody else signed it" in refusal_of(MINE, signing.sign(OTHER))
    assert "somebody else signed it" in refusal_of(MINE + b"x", signing.sign(MINE))
    ed25519 = pytest.importorskip("cryptography.hazmat.primitives.asymmetric.ed25519")
    strangers = ed25519.Ed25519PrivateKey.generate().sign(MINE)
    assert "somebody else signed it" in refusal_of(MINE, strangers)
    assert "somebody else signed it" in refusal_of(MINE, signing.sign(MINE) * 1000)


def test_the_key_of_the_start_is_the_one_that_counts(signing: "Ed25519PrivateKey", tmp_path: Path):
    flags = TrustedPolicyFlags(require_signature=tmp_path / "mine.pub")
    flags.check()
    (tmp_path / "mine.pub").write_bytes(b"")  # while the run waits for its door
    refusal_of = flags.refuses()
    assert refusal_of(MINE, signing.sign(MINE)) == ""
    assert refusal_of(MINE, b"") != ""
    (tmp_path / "policy.onnx").write_bytes(MINE)
    with pytest.raises(PolicyError, match="found none"):
        flags.check_watching(tmp_path / "policy.onnx")


def test_a_policy_that_only_watches_must_be_signed_as_well(
    signing: "Ed25519PrivateKey", tmp_path: Path
):
    watching = tmp_path / "watching.onnx"
    watching.write_bytes(MINE)
    flags = TrustedPolicyFlags("0" * 64, tmp_path / "mine.pub")  # the hash is the driving one's
    with pytest.raises(PolicyError, match=r"watching\.onnx\.sig"):
        flags.check_watching(watching)
    (tmp_path / "watching.onnx.sig").write_bytes(signing.sign(MINE))
    assert flags.check_watching(watching) == MINE
    assert flags.check_watching(None) is None
    assert TrustedPolicyFlags().check_watching(watching) is None


@pytest.mark.parametrize("wrong", [b"", bytes(63), bytes(65), b"QUJD" * 22])
def test_what_lies_beside_a_file_and_is_no_signature_is_not_sent(wrong: bytes, tmp_path: Path):
    policy = tmp_path / "policy.onnx"
    assert signature_beside(policy) == b""
    (tmp_path / "policy.onnx.sig").write_bytes(wrong)
    with pytest.raises(PolicyError, match="expected the 64 raw bytes of a signature"):
        signature_beside(policy)
