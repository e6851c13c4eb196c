"""The parts of the world's step that are compiled apart, each by its address.

Nothing checks what is handed over at such a call, so there are two forms of them: `look` and `put`
take parameters, scratch and which agent; the others also which layer, and a cell (two integers).
"""

from typing import NamedTuple


class Parts(NamedTuple):
    """Addresses; 0 where a world never needs the part."""

    look: int = 0
    """`senses.sense_agent`."""
    put: int = 0
    """`places.go_to_free_place`."""
    belt: int = 0
    """`gather.gather_belt`."""
    scatter: int = 0
    """`gather.gather_scatter`."""
    structure: int = 0
    """`gather.gather_structure`."""
