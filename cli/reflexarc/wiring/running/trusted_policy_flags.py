"""Which policy files a loop takes: only those that somebody vouched for."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from reflexarc_runtime.errors import PolicyError

if TYPE_CHECKING:
    from collections.abc import Callable

    from reflexarc_runtime.policy.acceptance import Acceptance
    from reflexarc_runtime.policy.policy import LoadedPolicy


@dataclass(frozen=True)
class TrustedPolicyFlags:
    """What a policy file must fulfil before anything of it is parsed."""

    expect_hash: str = ""
    """Take no policy but the one whose file has this SHA-256."""
    require_signature: Path | None = None
    """Take no policy but one that the owner of this public key (Ed25519, PEM) signed, in
    POLICY.onnx.sig beside it: `reflexarc secure sign`. It holds for one that watches as well, and
    for one that `reflexarc swap` sends."""

    @property
    def acceptance(self) -> "Acceptance":
        """The check, for files and for bytes."""
        from reflexarc_runtime.policy.acceptance import Acceptance

        key = b"" if self.require_signature is None else self.require_signature.read_bytes()
        return Acceptance(self.expect_hash.lower(), key)

    def refuses(self) -> "Callable[[bytes, bytes], str]":
        """Says why a policy that comes over the bus with a signature is not taken; empty: it is.

        The key is read now, and never again: what lies there later vouches for nothing.
        """
        acceptance = self.acceptance

        def refusal_of(policy: bytes, signature: bytes) -> str:
            try:
                acceptance.accept(policy, signature)
            except PolicyError as error:
                return str(error)
            return ""

        return refusal_of

    def check_file(self, path: Path) -> bytes | None:
        """Look at a file before it is parsed; the bytes that were accepted, None: any are.

        Raises:
            PolicyError: nobody vouched for it.
        """
        if not self.expect_hash and self.require_signature is None:
            return None
        return self.acceptance.accept_file(path)

    def check_watching(self, path: Path | None) -> bytes | None:
        """Look at the file of a policy that only watches: it is parsed like any other.

        The bytes that were accepted; None: any are.

        Raises:
            PolicyError: nobody signed it, where somebody must have.
        """
        if path is None or self.require_signature is None:
            return None
        return replace(self, expect_hash="").check_file(path)

    def check_loaded(self, accepted: bytes | None, policy: "LoadedPolicy") -> None:
        """Whether what was loaded is what was accepted: the file may have been changed meanwhile.

        Raises:
            PolicyError: it is not.
        """
        if accepted is not None and policy.data != accepted:
            raise PolicyError("the policy file was changed while it was read; start again")
