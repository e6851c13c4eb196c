"""The interface of a kind of layer (`LayerKind`), and checks that all kinds share.

A kind is a frozen dataclass here, whose fields are the keys of its table in a world file, and a
module of the same name in `obstacles/kinds/`, which draws its obstacles in compiled code.
"""

from typing import Any, ClassVar, NamedTuple, Protocol

from reflexarc_sim_bridge.worlds.checks import Span, require, require_span
from reflexarc_sim_bridge.worlds.grid import Across, Around
from reflexarc_sim_bridge.worlds.layer_motion import Motion

WHITE: tuple[Span, ...] = ((1.0, 1.0),)

NARROWEST_STRIPE_M, WIDEST_STRIPE_M = 0.05, 100.0


class MostNear(NamedTuple):
    """Most obstacles that can be near an agent, by the lists that they are kept in."""

    boxes: int = 0
    """Upright rectangles."""
    turned: int = 0
    """Turned rectangles."""
    discs: int = 0
    sides: int = 0
    """Sides of polygons, curves and slanting walls."""


class LayerKind(Protocol):
    """A kind of layer."""

    COLUMNS: ClassVar[Any]
    """Class of what `columns` returns: a named tuple of int and float."""

    @property
    def colour(self) -> tuple[Span, ...]:
        """Of each obstacle: one span for grey, or three for red, green and blue; 0 to 1."""

    @property
    def motion(self) -> Motion | None:
        """How the layer moves; None: it stands still."""

    @property
    def reach_m(self) -> float:
        """No obstacle reaches farther from its centre, along x or y.

        An obstacle's centre lies in the chunk that draws it.
        """

    def columns(self, across: Across) -> Any:
        """Its columns of the table of layers, which compiled code reads by their names.

        Args:
            across: of the world that it is in.
        """

    def most_near(self, around: Around) -> MostNear:
        """Most obstacles that can be near an agent: its lists have room for no more.

        Args:
            around: where obstacles count as near.
        """


def require_colour(where: str, colour: tuple[Span, ...]) -> None:
    """Refuse what is neither grey nor a colour."""
    require(len(colour) in (1, 3), where, "one span (grey) or three (red, green, blue)", colour)
    for span in colour:
        require_span(where, span, 0.0, 1.0)


def require_stripes(where: str, stripes_m: float, colour: tuple[Span, ...]) -> None:
    """Refuse stripes of no usable width, and those that could not be told apart."""
    bounds = f"0 (none), or {NARROWEST_STRIPE_M:g} to {WIDEST_STRIPE_M:g}"
    fits = stripes_m == 0.0 or NARROWEST_STRIPE_M <= stripes_m <= WIDEST_STRIPE_M
    require(fits, f"{where}.stripes_m", bounds, stripes_m)
    has_shades = any(low < high for low, high in colour)
    expected = "bounds that differ, as stripes draw their shades between them"
    require(stripes_m == 0.0 or has_shades, f"{where}.colour", expected, colour)
