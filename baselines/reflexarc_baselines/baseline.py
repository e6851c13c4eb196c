"""What a baseline is: a policy written by hand, with the contract that it drives by.

A baseline is a frozen dataclass. Its fields are its parameters, each with the value that was found
by the search that every baseline gets (`SEARCHED`), or that its source gives. It decides for many
agents at once, by plain NumPy, and keeps nothing between two calls: what it remembers is a row of
float32 values that its caller keeps (`Remembering`), so that it can be exported and replayed.

Every baseline chooses between the contract's actions stay, left and right. Commands to halt or to
slow down, which some sources have, do nothing at uniform speed; each module says so where its
source has them.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import ClassVar, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.arrays import Actions, Memories, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract

Floats: TypeAlias = npt.NDArray[np.float32]


class Fidelity(StrEnum):
    """How near to its source a baseline is."""

    FAITHFUL = "faithful"
    """Equations and constants of the source."""
    ADAPTED = "adapted"
    """Equations of the source, on these senses and actions."""
    RECONSTRUCTED = "reconstructed"
    """The source, or its numbers, could not be read: rebuilt from what is said of it."""
    OURS = "ours"
    """No source: a plain rule."""


class Sees(StrEnum):
    """What a baseline was made to see."""

    RETINA = "retina"
    """The retina as it is, with its colours."""
    RANGES = "ranges"
    """Distances, as a range finder gives them: for it every world is white before black."""


@dataclass(frozen=True)
class Origin:
    """Where a baseline comes from."""

    source: str
    """Authors, title, year; or what is known where no source was found."""
    fidelity: Fidelity
    sees: Sees = Sees.RETINA
    home_world: str = "reference-1"
    """The world that it was made for, where it has to beat random motion."""
    remarks: str = ""
    """What is not as in the source, in a sentence."""


@dataclass(frozen=True)
class Span:
    """Where the search looks for a parameter."""

    low: float
    high: float
    is_log: bool = False
    """Whether it is drawn evenly in its logarithm."""
    is_whole: bool = False
    """Whether it is a whole number."""


class Baseline(Protocol):
    """A policy written by hand that remembers nothing."""

    ORIGIN: ClassVar[Origin]
    SEARCHED: ClassVar[Mapping[str, Span]]
    """The fields that the search may set; empty where the source fixes all."""

    @property
    def contract(self) -> PolicyContract:
        """What it sees and does."""
        ...

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """See `reflexarc_runtime.policy.policy.Policy`."""
        ...


class Remembering(Protocol):
    """A baseline whose contract has a memory."""

    ORIGIN: ClassVar[Origin]
    SEARCHED: ClassVar[Mapping[str, Span]]

    @property
    def contract(self) -> PolicyContract:
        """What it sees, does and remembers; the memory starts at `contract.state.start_value`."""
        ...

    def decide(self, retinas: RetinaBatch, memories: Memories) -> tuple[QValues, Actions, Memories]:
        """See `reflexarc_runtime.policy.policy.RememberingPolicy`."""
        ...
