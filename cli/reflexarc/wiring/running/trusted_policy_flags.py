"""Which policy files a loop takes: only those that somebody vouched for."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from reflexarc_runtime.errors import PolicyError

if TYPE_CHECKING:
    from reflexarc_runtime.policy.acceptance import Acceptance
    from reflexarc_runtime.policy.policy import LoadedPolicy


@dataclass(frozen=True)
class TrustedPolicyFlags:
    """What a policy file must fulfil before anything of it is parsed."""

    expect_hash: str = ""
    """Take no policy but the one whose file has this SHA-256."""
    require_signature: Path | None = None
    """Take no policy but one that the owner of this public key (Ed25519, PEM) signed, in
    POLICY.onnx.sig beside it: `reflexarc secure sign`."""

    @property
    def acceptance(self) -> "Acceptance":
        """The check, for files and for bytes."""
        from reflexarc_runtime.policy.acceptance import Acceptance

        key = b"" if self.require_signature is None else self.require_signature.read_bytes()
        return Acceptance(self.expect_hash.lower(), key)

    def refusal_of(self, policy: bytes) -> str:
        """Why a policy that comes over the bus, without a signature, is not taken; empty: it is."""
        try:
            self.acceptance.accept(policy)
        except PolicyError as error:
            return str(error)
        return ""

    def check_file(self, path: Path) -> bytes | None:
        """Look at a file before it is parsed; the bytes that were accepted, None: any are.

        Raises:
            PolicyError: nobody vouched for it.
        """
        if not self.expect_hash and self.require_signature is None:
            return None
        return self.acceptance.accept_file(path)

    def check_loaded(self, accepted: bytes | None, policy: "LoadedPolicy") -> None:
        """Whether what was loaded is what was accepted: the file may have been changed meanwhile.

        Raises:
            PolicyError: it is not.
        """
        if accepted is not None and policy.data != accepted:
            raise PolicyError("the policy file was changed while it was read; start again")
