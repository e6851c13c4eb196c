"""Whether the bytes of a policy file are those that somebody vouched for.

Asked before anything of the file is parsed. A signature is Ed25519 (RFC 8032) over all bytes of
the file, raw, 64 bytes, in a file of its own beside it, `policy.onnx.sig`: what
`openssl pkeyutl -verify -rawin -pubin -inkey KEY -in FILE -sigfile FILE.sig` checks.
"""

import hashlib
import hmac
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from reflexarc_runtime.errors import PolicyError, UsageError, first_line
from reflexarc_runtime.files import read_at_most
from reflexarc_runtime.policy.model_file import read_model

if TYPE_CHECKING:
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey

_SHA256 = re.compile(r"[0-9a-f]{64}")
SIGNATURE_BYTES = 64


def signature_path(policy: Path) -> Path:
    """Where the signature of a file is."""
    return policy.parent / f"{policy.name}.sig"


def signature_beside(policy: Path) -> bytes:
    """The signature that lies beside a file; empty where none does.

    Raises:
        PolicyError: what lies there is none.
    """
    path = signature_path(policy)
    try:
        signature = read_at_most(path, SIGNATURE_BYTES)
    except FileNotFoundError:
        return b""
    if len(signature) != SIGNATURE_BYTES:
        got = "more" if len(signature) > SIGNATURE_BYTES else f"{len(signature)}"
        raise PolicyError(
            f"{path}: expected the {SIGNATURE_BYTES} raw bytes of a signature, got {got}; make it "
            "anew: `reflexarc secure sign`"
        )
    return signature


@dataclass(frozen=True)
class Acceptance:
    """What a policy must fulfil before it is parsed.

    What is asked for is asked for: a hash or a key that is empty is refused, not ignored.

    Raises:
        UsageError: the hash or the key is none.
        ModuleNotFoundError: a signature is asked for, and the extra `secure` is missing.
    """

    sha256: str | None = None
    """Of all its bytes, in hexadecimal; None: any."""
    public_key: bytes | None = None
    """Of who must have signed it, as PEM; None: nobody need have."""

    def __post_init__(self) -> None:
        if self.sha256 is not None and _SHA256.fullmatch(self.sha256) is None:
            raise UsageError(
                f"--expect-hash: expected a SHA-256, 64 digits of 0-9a-f, got {self.sha256!r}"
            )
        if self.public_key is not None:
            _parse_key(self.public_key)

    def accept(self, policy: bytes, signature: bytes = b"") -> None:
        """Look at the bytes of a file, and at the signature that came with it.

        Raises:
            PolicyError: they are not those that were vouched for.
        """
        found = hashlib.sha256(policy).hexdigest()
        if self.sha256 is not None and not hmac.compare_digest(found, self.sha256):
            raise PolicyError(
                f"expected the file of SHA-256 {self.sha256} (--expect-hash), got {found}"
            )
        if self.public_key is not None:
            _verify(_parse_key(self.public_key), policy, signature)

    def accept_file(self, path: Path) -> bytes:
        """Look at a file and the signature beside it; return the bytes that were accepted.

        Raises:
            PolicyError: it cannot be read, or see `accept`; the line names the file.
        """
        policy = read_model(path)
        signature = b"" if self.public_key is None else _needed_signature(path)
        try:
            self.accept(policy, signature)
        except PolicyError as error:
            raise PolicyError(f"{path}: {error}") from None
        return policy


def _needed_signature(policy: Path) -> bytes:
    signature = signature_beside(policy)
    if not signature:
        raise PolicyError(
            f"{policy}: expected its signature in {signature_path(policy).name} "
            "(--require-signature), found none: `reflexarc secure sign`"
        )
    return signature


def _parse_key(pem: bytes) -> "Ed25519PublicKey":
    from cryptography.exceptions import UnsupportedAlgorithm
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey
    from cryptography.hazmat.primitives.serialization import load_pem_public_key

    try:
        key = load_pem_public_key(pem)
    except (ValueError, UnsupportedAlgorithm) as error:
        said = first_line(error) if pem else "the file is empty"
        raise UsageError(f"--require-signature: not a public key: {said}") from None
    if not isinstance(key, Ed25519PublicKey):
        raise UsageError("--require-signature: expected a public key of Ed25519")
    return key


def _verify(key: "Ed25519PublicKey", policy: bytes, signature: bytes) -> None:
    from cryptography.exceptions import InvalidSignature

    if not signature:
        raise PolicyError(
            "expected a signature by the key of --require-signature, got none: "
            "`reflexarc secure sign` writes one beside the file"
        )
    try:
        key.verify(signature, policy)
    except InvalidSignature:
        raise PolicyError(
            f"expected a signature by the key of --require-signature, got {len(signature)} "
            f"bytes that are none of these {len(policy)} bytes: the file was changed, or "
            "somebody else signed it"
        ) from None
