"""Checks of the fields of a world: one line that says where, what was expected and what came."""

import math
from typing import TypeAlias

from reflexarc_runtime.config import checks
from reflexarc_runtime.errors import WorldError

Span: TypeAlias = tuple[float, float]
"""Bounds of a uniform distribution, lowest first."""


def require(holds: bool, where: str, expected: str, got: object) -> None:
    """Refuse a field of a world unless `holds`.

    Raises:
        WorldError: it does not hold.
    """
    checks.require(holds, f"world.{where}", expected, got, WorldError)


def require_within(where: str, value: float, least: float, most: float) -> None:
    """A number between two bounds, both included."""
    holds = math.isfinite(value) and least <= value <= most
    require(holds, where, f"{least:g} to {most:g}", value)


def require_span(where: str, span: Span, least: float, most: float) -> None:
    """Two numbers within bounds, the lower one first."""
    holds = len(span) == 2 and least <= span[0] <= span[1] <= most
    require(holds, where, f"(low, high) within {least:g} to {most:g}", span)
