"""Which policy files a loop takes: only those that somebody vouched for."""

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from reflexarc_runtime.errors import PolicyError, UsageError

if TYPE_CHECKING:
    from collections.abc import Callable

    from reflexarc_runtime.policy.acceptance import Acceptance

_MOST_KEY_BYTES = 1 << 16
"""Of a public key as PEM; that of Ed25519 takes a hundred."""


@dataclass(frozen=True)
class TrustedPolicyFlags:
    """What a policy file must fulfil before anything of it is parsed."""

    expect_hash: str | None = None
    """Take no policy but the one whose file has this SHA-256."""
    require_signature: Path | None = None
    """Take no policy but one that the owner of this public key (Ed25519, PEM) signed, in
    POLICY.onnx.sig beside it: `reflexarc secure sign`. It holds for one that watches as well, and
    for one that `reflexarc swap` sends."""

    @cached_property
    def acceptance(self) -> "Acceptance":
        """The check, for files and for bytes.

        The key is read when this is first asked for, and never again: what lies there later
        vouches for nothing.

        Raises:
            UsageError: the hash or the key is none.
        """
        from reflexarc_runtime.policy.acceptance import Acceptance

        sha256 = None if self.expect_hash is None else self.expect_hash.lower()
        return Acceptance(sha256, self._key())

    def _key(self) -> bytes | None:
        from reflexarc_runtime.files import read_at_most

        if self.require_signature is None:
            return None
        pem = read_at_most(self.require_signature, _MOST_KEY_BYTES)
        if len(pem) > _MOST_KEY_BYTES:
            raise UsageError(
                f"--require-signature: {self.require_signature}: expected a public key, got more "
                f"than {_MOST_KEY_BYTES >> 10} KiB"
            )
        return pem

    def check(self) -> None:
        """Read what is asked for, before anything else is done.

        Raises:
            UsageError: the hash or the key is none.
        """
        _ = self.acceptance

    def refuses(self) -> "Callable[[bytes, bytes], str]":
        """Says why a policy that comes over the bus with a signature is not taken; empty: it is."""
        acceptance = self.acceptance

        def refusal_of(policy: bytes, signature: bytes) -> str:
            try:
                acceptance.accept(policy, signature)
            except PolicyError as error:
                return str(error)
            return ""

        return refusal_of

    def check_file(self, path: Path) -> bytes:
        """Read a file, once, and look at it before it is parsed; the bytes that were accepted.

        Raises:
            PolicyError: it cannot be read, or nobody vouched for it.
        """
        return self.acceptance.accept_file(path)

    def check_watching(self, path: Path | None) -> bytes | None:
        """Look at the file of a policy that only watches: it is parsed like any other.

        The bytes that were accepted; None: any are.

        Raises:
            PolicyError: nobody signed it, where somebody must have.
        """
        if path is None or self.require_signature is None:
            return None
        return replace(self.acceptance, sha256=None).accept_file(path)
