"""Two small networks with a memory: a GRU and an LSTM behind the retina, a linear layer for Q.

    retina → flatten → recurrent layer of `hidden` units ⇄ memory → Q = W h + b

The memory of a GRU is its h; that of an LSTM is h and c, side by side.
"""

from typing import TypeVar

import torch
from torch import Tensor, nn

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.state_spec import StateSpec
from reflexarc_runtime.errors import UsageError

_Recurrent = TypeVar("_Recurrent", nn.GRU, nn.LSTM)


class GruNetwork(nn.Module):
    """A GRU: remembers `hidden` values.

    Args:
        contract: what it sees and does; its memory must be `GruNetwork.memory(hidden)`.
        hidden: units of the recurrent layer.
        seed: of the initial weights.
    """

    def __init__(self, contract: PolicyContract, hidden: int, seed: int = 0) -> None:
        super().__init__()
        _check_memory(contract, self.memory(hidden))
        self.gru, self.head = _layers(nn.GRU, contract, hidden, seed)

    @staticmethod
    def memory(hidden: int) -> StateSpec:
        """The memory that its contract must have."""
        return StateSpec(size=hidden)

    def forward(self, retinas: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
        """Q-values (n, actions) and the next memories (n, hidden).

        Args:
            retinas: floats in [0, 1] (n, frames, eyes, rays, channels).
            state: memories (n, hidden).
        """
        _, h = self.gru(retinas.flatten(1).unsqueeze(0), state.unsqueeze(0))
        h = h.squeeze(0)
        return self.head(h), h


class LstmNetwork(nn.Module):
    """An LSTM: remembers 2 × `hidden` values.

    Args:
        contract: what it sees and does; its memory must be `LstmNetwork.memory(hidden)`.
        hidden: units of the recurrent layer.
        seed: of the initial weights.
    """

    def __init__(self, contract: PolicyContract, hidden: int, seed: int = 0) -> None:
        super().__init__()
        _check_memory(contract, self.memory(hidden))
        self.lstm, self.head = _layers(nn.LSTM, contract, hidden, seed)

    @staticmethod
    def memory(hidden: int) -> StateSpec:
        """The memory that its contract must have."""
        return StateSpec(size=2 * hidden)

    def forward(self, retinas: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
        """Q-values (n, actions) and the next memories (n, 2 × hidden).

        Args:
            retinas: floats in [0, 1] (n, frames, eyes, rays, channels).
            state: memories (n, 2 × hidden): h, then c.
        """
        h, c = state.unsqueeze(0).chunk(2, dim=2)
        _, (h, c) = self.lstm(retinas.flatten(1).unsqueeze(0), (h.contiguous(), c.contiguous()))
        return self.head(h.squeeze(0)), torch.cat([h, c], dim=2).squeeze(0)


def _layers(
    kind: type[_Recurrent], contract: PolicyContract, hidden: int, seed: int
) -> tuple[_Recurrent, nn.Linear]:
    """The recurrent layer and the one behind it, with the weights of a seed."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        layer = kind(_inputs(contract), hidden, dtype=torch.float64)
        return layer, nn.Linear(hidden, len(contract.actions), dtype=torch.float64)


def _inputs(contract: PolicyContract) -> int:
    return contract.retina.frames * contract.retina.size


def _check_memory(contract: PolicyContract, wanted: StateSpec) -> None:
    got = contract.state.size
    if got != wanted.size:
        raise UsageError(
            f"expected a contract with a memory of {wanted.size} values, got {got}; replace its "
            f"`state` by StateSpec(size={wanted.size})"
        )
