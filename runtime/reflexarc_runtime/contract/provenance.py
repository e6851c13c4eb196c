"""Where a policy comes from."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Provenance:
    """Where a policy comes from."""

    preset: str = ""
    seed: int = 0
    config: Mapping[str, Any] = field(default_factory=dict)
    """The resolved training configuration."""
    config_hash: str = ""
    """SHA-256 of the configuration's canonical JSON."""
    versions: Mapping[str, str] = field(default_factory=dict)
    commit: str = ""
    scores: Mapping[str, float] = field(default_factory=dict)
    """What evaluation measured, by name with unit."""
