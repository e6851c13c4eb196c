"""A policy that was accepted is the one that is loaded."""

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from reflexarc.wiring.running.trusted_policy_flags import TrustedPolicyFlags
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.acceptance import signature_beside
from reflexarc_runtime.policy.policy import load_policy
from support.policies import exported

if TYPE_CHECKING:
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey


def test_a_file_that_is_changed_between_the_look_and_the_load_is_refused(tmp_path: Path):
    path, mine = tmp_path / "policy.onnx", exported(PolicyContract(), seed=5)
    path.write_bytes(mine)
    flags = TrustedPolicyFlags(expect_hash=hashlib.sha256(mine).hexdigest().upper())
    accepted = flags.check_file(path)
    flags.check_loaded(accepted, load_policy(path))
    path.write_bytes(exported(PolicyContract(), seed=6))
    with pytest.raises(PolicyError, match="changed while it was read"):
        flags.check_loaded(accepted, load_policy(path))
    with pytest.raises(PolicyError, match="--expect-hash"):
        flags.check_file(path)


def test_without_the_flags_any_file_is_taken(tmp_path: Path):
    assert TrustedPolicyFlags().check_file(tmp_path / "none.onnx") is None


MINE, OTHER = exported(PolicyContract(), seed=5), exported(PolicyContract(), seed=6)


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
    refusal_of = TrustedPolicyFlags(require_signature=tmp_path / "mine.pub").refuses()
    (tmp_path / "mine.pub").unlink()
    assert refusal_of(MINE, signing.sign(MINE)) == ""


def test_a_policy_that_only_watches_must_be_signed_as_well(
    signing: "Ed25519PrivateKey", tmp_path: Path
):
    watching = tmp_path / "watching.onnx"
    watching.write_bytes(MINE)
    flags = TrustedPolicyFlags("0" * 64, tmp_path / "mine.pub")  # the hash is the driving one's
    with pytest.raises(PolicyError, match=r"watching\.onnx\.sig"):
        flags.check_watching(watching)
    (tmp_path / "watching.onnx.sig").write_bytes(signing.sign(MINE))
    flags.check_watching(watching)
    TrustedPolicyFlags().check_watching(watching)


@pytest.mark.parametrize("wrong", [b"", bytes(63), bytes(65), b"QUJD" * 22])
def test_what_lies_beside_a_file_and_is_no_signature_is_not_sent(wrong: bytes, tmp_path: Path):
    policy = tmp_path / "policy.onnx"
    assert signature_beside(policy) == b""
    (tmp_path / "policy.onnx.sig").write_bytes(wrong)
    with pytest.raises(PolicyError, match="expected the 64 raw bytes of a signature"):
        signature_beside(policy)
