"""Who shall be measured, before it is made: a name and the text that any process makes it from."""

import hashlib
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path

from reflexarc_runtime.policy.model_file import policy_hash, read_model
from reflexarc_runtime.policy.policy import Backend
from reflexarc_sim_bridge.evaluation.protocol.contender import (
    BLIND,
    RANDOM,
    Contender,
    contender_of,
)
from reflexarc_sim_bridge.native.cache import source_key

CODE = ":"
"""What a source of code has between its module and its class."""
_UNREAD = ".pyc"


@dataclass(frozen=True)
class Entrant:
    """Who shall be measured."""

    name: str
    """How tables call it."""
    source: str
    """See `contender_of`."""
    is_guarded: bool = False
    rate_hz: float | None = None
    """Instead of its contract's."""
    backend: str = Backend.NUMPY.value
    """What computes it, if it is a file."""

    def contender(self) -> Contender:
        """Made anew.

        Raises:
            ReflexarcError: see `contender_of`.
        """
        made = contender_of(self.source, is_guarded=self.is_guarded, backend=self.backend)
        made = replace(made, name=self.name)
        if self.rate_hz is None:
            return made
        return replace(made, contract=replace(made.contract, rate_hz=self.rate_hz))

    @property
    def is_code(self) -> bool:
        """Whether it is a class, not a file."""
        return CODE in self.source and not Path(self.source).exists()

    def content_hash(self) -> str:
        """SHA-256 of the file; of a class, of its package's code and of the files beside it.

        Of a file on another backend than the usual one, of that too.

        What a class reads elsewhere does not show in it.
        """
        if self.source in (BLIND, RANDOM):
            return ""
        if not self.is_code:
            own = policy_hash(read_model(Path(self.source)))
            is_usual = self.backend == Backend.NUMPY
            return own if is_usual else hashlib.sha256((own + self.backend).encode()).hexdigest()
        digest = hashlib.sha256()
        name = self.source.partition(CODE)[0]
        for path in _files_of(name):
            digest.update(path.name.encode() + path.read_bytes())
        if not name.endswith(".py"):
            digest.update(source_key((name.partition(".")[0],)).encode())
        return digest.hexdigest()


def _files_of(name: str) -> list[Path]:
    """The file of a module, and those beside it if it is part of a package."""
    if name.endswith(".py"):
        return [Path(name)]
    spec = find_spec(name)
    if spec is None or spec.origin is None:
        return []
    own = Path(spec.origin)
    beside = own.parent.iterdir() if "." in name else [own]
    return sorted(path for path in beside if path.is_file() and path.suffix != _UNREAD)
