"""Configurations that earlier versions wrote, as those of today."""

from collections.abc import Mapping
from typing import Any

from reflexarc_runtime.config.source import MappingSource

_PARTS = (
    ("worlds",),
    ("retina", "shading"),
    ("network",),
    ("learner", "exploration"),
    ("learner", "online"),
    ("learner", "batched"),
    ("validation",),
)
"""What a configuration of any version has."""


def as_of_today(document: Mapping[str, Any]) -> dict[str, Any]:
    """A configuration with what earlier versions meant where they said nothing, or said less."""
    network, retina = document.get("network"), document.get("retina")
    if isinstance(network, dict) and isinstance(network.get("hidden"), int):
        # There was one hidden layer, whose `hidden` was a plain number.
        network = {**network, "hidden": [network["hidden"]]}
    if isinstance(retina, dict):
        # Written out: today's default is another.
        retina = {"beams": "nearest_beam", **retina}
    return {**document, "network": network, "retina": retina}


def require_parts(source: MappingSource) -> None:
    """Refuse a document without the parts that every version wrote; later fields have defaults."""
    for path in _PARTS:
        part: Any = source.document
        for name in path:
            part = part.get(name) if isinstance(part, Mapping) else None
        if not part:
            raise source.complaint(path, "missing")
