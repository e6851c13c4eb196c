"""A unit of a suite: one contender, or one limit, in one cell; what any process can do for itself.

Its key is a hash of everything that its sums depend on: the text of the world, how much of it is
driven, the contender's bytes, rate and body, the code and the versions of what computes. Equal keys
have equal sums, so that what was done once is not done again.
"""

import hashlib
import json
import platform
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import lru_cache
from importlib.metadata import version
from typing import Any, Self

from reflexarc_runtime.config.fill import fill
from reflexarc_runtime.config.source import MappingSource
from reflexarc_sim_bridge.evaluation.protocol.entrant import Entrant
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite, SuiteCell, SuiteFamily
from reflexarc_sim_bridge.native.cache import source_key
from reflexarc_sim_bridge.worlds.files import world_text

_SOURCES = "reflexarc_runtime/", "reflexarc_sim_bridge/"
_PACKAGES = "numpy", "numba"
_NAMES = "tier", "world", "counts"
"""Of a cell, what its sums do not depend on; of its world counts the text."""


@dataclass(frozen=True)
class Amount:
    """How much of a cell is driven: see `Suite`."""

    worlds: int
    lanes: int
    free_paths: float
    turner_s: float

    @classmethod
    def of(cls, suite: Suite) -> Self:
        """That of a suite."""
        return cls(suite.worlds, suite.lanes, suite.free_paths, suite.turner_s)

    def suite(self, cell: SuiteCell) -> Suite:
        """A suite of one cell."""
        return Suite("unit", 0, **asdict(self), families=(SuiteFamily("unit", cells=(cell,)),))


@dataclass(frozen=True)
class SuiteUnit:
    """One contender, or one limit, in one cell."""

    amount: Amount
    cell: SuiteCell
    setting: Setting
    content: str
    """Hash of whoever drives: see `Entrant.content_hash`."""
    code: str
    """See `evaluation_code`."""
    entrant: Entrant | None = None
    """Who drives; None: a limit."""
    limit: str = ""
    """Name of the limit."""
    motion: str = ""
    """Contract of the limit's motion, as text."""

    def to_plain(self) -> dict[str, Any]:
        """As plain JSON values."""
        plain: dict[str, Any] = json.loads(json.dumps(asdict(self)))
        return plain

    @classmethod
    def from_plain(cls, document: Mapping[str, Any]) -> Self:
        """What `to_plain` gave."""
        return fill(cls, MappingSource(document, "unit"), require_all=True)

    def key(self, rate_hz: float, body: object) -> str:
        """Equal for units with equal sums.

        Args:
            rate_hz: at which it drives in this setting.
            body: with which it drives.
        """
        cell, entrant = self.cell, self.entrant
        facts = {
            "amount": asdict(self.amount),
            "world": hashlib.sha256(world_text(cell.world).encode()).hexdigest(),
            "cell": {name: value for name, value in asdict(cell).items() if name not in _NAMES},
            "drives": (rate_hz, repr(body)),
            "who": (self.content, self.limit, self.motion, self.code),
            "entrant": entrant and (entrant.source, entrant.is_guarded, entrant.rate_hz),
        }
        return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()


@lru_cache(maxsize=1)
def evaluation_code() -> str:
    """Hash of the code and the versions that sums depend on."""
    versions = [platform.python_version(), *map(version, _PACKAGES)]
    text = json.dumps([source_key(_SOURCES), versions])
    return hashlib.sha256(text.encode()).hexdigest()[:16]
