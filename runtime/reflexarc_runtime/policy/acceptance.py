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

from reflexarc_runtime.errors import PolicyError, UsageError, first_line

_SHA256 = re.compile(r"[0-9a-f]{64}")
SIGNATURE_BYTES = 64


def signature_path(policy: Path) -> Path:
    """Where the signature of a file is."""
    return policy.with_name(f"{policy.name}.sig")


def signature_beside(policy: Path) -> bytes:
    """The signature that lies beside a file; empty where none does.

    Raises:
        PolicyError: what lies there is none.
    """
    path = signature_path(policy)
    try:
        with path.open("rb") as file:
            signature = file.read(SIGNATURE_BYTES + 1)
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
    """What a policy must fulfil before it is parsed."""

    sha256: str = ""
    """Of all its bytes, in hexadecimal; empty: any."""
    public_key: bytes = b""
    """Of who must have signed it, as PEM; empty: nobody need have."""

    def __post_init__(self) -> None:
        if self.sha256 and _SHA256.fullmatch(self.sha256) is None:
            raise UsageError(
                f"--expect-hash: expected a SHA-256, 64 digits of 0-9a-f, got {self.sha256!r}"
            )

    @property
    def asks(self) -> bool:
        """Whether it asks for anything."""
        return bool(self.sha256 or self.public_key)

    def accept(self, policy: bytes, signature: bytes = b"") -> None:
        """Look at the bytes of a file, and at the signature that came with it.

        Raises:
            PolicyError: they are not those that were vouched for.
            UsageError: the key is none.
            ModuleNotFoundError: a signature is asked for, and the extra `secure` is missing.
        """
        found = hashlib.sha256(policy).hexdigest()
        if self.sha256 and not hmac.compare_digest(found, self.sha256):
            raise PolicyError(
                f"expected the file of SHA-256 {self.sha256} (--expect-hash), got {found}"
            )
        if self.public_key:
            self._verify(policy, signature)

    def accept_file(self, path: Path) -> bytes:
        """Look at a file and the signature beside it; return the bytes that were accepted.

        Raises:
            PolicyError: see `accept`; the line names the file.
        """
        policy = path.read_bytes()
        try:
            self.accept(policy, self._signature_beside(path))
        except PolicyError as error:
            raise PolicyError(f"{path}: {error}") from None
        return policy

    def _signature_beside(self, path: Path) -> bytes:
        if not self.public_key:
            return b""
        try:
            return signature_path(path).read_bytes()
        except FileNotFoundError:
            raise PolicyError(
                f"expected its signature in {signature_path(path).name} (--require-signature), "
                "found none: `reflexarc secure sign`"
            ) from None

    def _verify(self, policy: bytes, signature: bytes) -> None:
        from cryptography.exceptions import InvalidSignature
        from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey
        from cryptography.hazmat.primitives.serialization import load_pem_public_key

        try:
            key = load_pem_public_key(self.public_key)
        except ValueError as error:
            raise UsageError(
                f"--require-signature: not a public key: {first_line(error)}"
            ) from None
        if not isinstance(key, Ed25519PublicKey):
            raise UsageError("--require-signature: expected a public key of Ed25519")
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
