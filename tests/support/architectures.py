"""Networks as users write them, of every kind that can be exported: retinas (n, 1, 1, 16, 1) → Q.

Each is made by a function of a seed; `scaled` multiplies its weights by a gain.
"""

from collections.abc import Callable

import torch
from torch import Tensor, nn

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.state_spec import StateSpec

RAYS, HIDDEN, ACTIONS = 16, 32, 3

ACTIVATIONS: dict[str, Callable[[], nn.Module]] = {
    "ReLU": nn.ReLU,
    "LeakyReLU": lambda: nn.LeakyReLU(0.2),
    "ELU": lambda: nn.ELU(0.7),
    "CELU": lambda: nn.CELU(1.3),
    "SELU": nn.SELU,
    "GELU": nn.GELU,
    "GELU by tanh": lambda: nn.GELU("tanh"),
    "SiLU": nn.SiLU,
    "Tanh": nn.Tanh,
    "Sigmoid": nn.Sigmoid,
    "Softplus": nn.Softplus,
    "Softplus of beta": lambda: nn.Softplus(2.5),
    "LogSigmoid": nn.LogSigmoid,
    "Softsign": nn.Softsign,
    "Hardtanh": lambda: nn.Hardtanh(-0.8, 1.5),
    "Hardsigmoid": nn.Hardsigmoid,
    "ReLU6": nn.ReLU6,
    "Hardswish": nn.Hardswish,
    "Mish": nn.Mish,
    "PReLU": nn.PReLU,
    "PReLU of every unit": lambda: nn.PReLU(HIDDEN, 0.3),
    "RReLU": nn.RReLU,
}


class Rays(nn.Module):
    """The retina as one row of a channel: (n, 1, 16)."""

    def forward(self, x: Tensor) -> Tensor:
        return x.reshape(x.shape[0], 1, -1)


class Dueling(nn.Module):
    """Value plus advantages less their mean (Wang et al. 2016)."""

    def __init__(self) -> None:
        super().__init__()
        self.body = nn.Sequential(nn.Flatten(), nn.Linear(RAYS, HIDDEN), nn.ReLU())
        self.value, self.advantage = nn.Linear(HIDDEN, 1), nn.Linear(HIDDEN, ACTIONS)

    def forward(self, x: Tensor) -> Tensor:
        body = self.body(x)
        advantage = self.advantage(body)
        q: Tensor = self.value(body) + advantage - advantage.mean(dim=1, keepdim=True)
        return q


class Residual(nn.Module):
    """Two layers around which the input goes, too, each normalised first."""

    def __init__(self) -> None:
        super().__init__()
        self.first, self.head = nn.Linear(RAYS, HIDDEN), nn.Linear(HIDDEN, ACTIONS)
        self.blocks = nn.ModuleList(
            nn.Sequential(nn.LayerNorm(HIDDEN), nn.Linear(HIDDEN, HIDDEN), nn.GELU())
            for _ in range(2)
        )

    def forward(self, x: Tensor) -> Tensor:
        x = self.first(x.flatten(1))
        for block in self.blocks:
            x = x + block(x)
        q: Tensor = self.head(x)
        return q


class Attention(nn.Module):
    """Rays that look at each other."""

    def __init__(self) -> None:
        super().__init__()
        self.inward, self.head = nn.Linear(1, 24), nn.Linear(8, ACTIONS)

    def forward(self, x: Tensor) -> Tensor:
        query, key, value = self.inward(x.reshape(-1, RAYS, 1)).chunk(3, dim=-1)
        shares = torch.softmax(query @ key.transpose(1, 2) / 8**0.5, dim=-1)
        q: Tensor = self.head((shares @ value).mean(dim=1))
        return q


class TwoViews(nn.Module):
    """The left and the right half by themselves, joined, with the brightest ray beside them."""

    def __init__(self) -> None:
        super().__init__()
        self.side, self.head = nn.Linear(RAYS // 2, 8), nn.Linear(17, ACTIONS)

    def forward(self, x: Tensor) -> Tensor:
        x = x.float().view(-1, RAYS)
        left, right = x[:, : RAYS // 2], x[:, RAYS // 2 :]
        brightest = x.max(dim=1, keepdim=True).values
        joined = torch.cat([torch.tanh(self.side(left)), torch.tanh(self.side(right))], dim=1)
        q: Tensor = self.head(torch.cat([joined, brightest], dim=1))
        return q


class Remembering(nn.Module):
    """A GRU cell, or an LSTM cell whose h and c lie side by side."""

    def __init__(self, kind: str) -> None:
        super().__init__()
        self.is_lstm = kind == "LSTM"
        self.cell = (nn.LSTMCell if self.is_lstm else nn.GRUCell)(RAYS, 8)
        self.head = nn.Linear(8, ACTIONS)

    def forward(self, x: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
        x = x.flatten(1)
        if not self.is_lstm:
            h = self.cell(x, state)
            return self.head(h), h
        h, c = state.chunk(2, dim=1)
        h, c = self.cell(x, (h, c))
        return self.head(h), torch.cat([h, c], dim=1)


def layers(activation: Callable[[], nn.Module]) -> nn.Module:
    """Two hidden layers of an activation."""
    return nn.Sequential(
        nn.Flatten(),
        nn.Linear(RAYS, HIDDEN),
        activation(),
        nn.Linear(HIDDEN, HIDDEN),
        activation(),
        nn.Linear(HIDDEN, ACTIONS),
    )


def _along_rays(*modules: nn.Module, size: int) -> nn.Module:
    return nn.Sequential(Rays(), *modules, nn.Flatten(), nn.Linear(size, ACTIONS))


STRUCTURES: dict[str, Callable[[], nn.Module]] = {
    "Conv1d": lambda: _along_rays(
        nn.Conv1d(1, 8, 5, stride=2, padding=2), nn.ReLU(), nn.Conv1d(8, 8, 3), nn.ReLU(), size=48
    ),
    "Conv1d around a ring, groups": lambda: _along_rays(
        nn.Conv1d(1, 4, 3, padding=1, padding_mode="circular"),
        nn.ELU(),
        nn.Conv1d(4, 8, 3, groups=2, dilation=2),
        nn.Hardswish(),
        size=96,
    ),
    "Conv1d, BatchNorm, pools": lambda: _along_rays(
        nn.Conv1d(1, 8, 3, padding="same"),
        nn.BatchNorm1d(8),
        nn.LeakyReLU(),
        nn.MaxPool1d(2),
        nn.Conv1d(8, 8, 3, padding=1),
        nn.SiLU(),
        nn.AvgPool1d(3, 1, 1),
        nn.AdaptiveAvgPool1d(4),
        size=32,
    ),
    "Conv2d": lambda: nn.Sequential(
        nn.Unflatten(3, (4, 4)),
        nn.Flatten(1, 2),
        nn.Flatten(3, 4),
        nn.Conv2d(1, 6, 3, padding=1, padding_mode="reflect"),
        nn.ReLU(),
        nn.MaxPool2d(2),
        nn.Flatten(),
        nn.Linear(24, ACTIONS),
    ),
    "Dueling": Dueling,
    "LayerNorm": lambda: layers(lambda: nn.Sequential(nn.LayerNorm(HIDDEN), nn.ReLU())),
    "RMSNorm": lambda: layers(lambda: nn.Sequential(nn.RMSNorm(HIDDEN), nn.Mish())),
    "BatchNorm, Dropout": lambda: layers(
        lambda: nn.Sequential(nn.BatchNorm1d(HIDDEN), nn.Tanh(), nn.Dropout(0.2))
    ),
    "Residual": Residual,
    "Softmax head": lambda: nn.Sequential(layers(nn.ReLU), nn.Softmax(dim=1)),
    "LogSoftmax head": lambda: nn.Sequential(layers(nn.ReLU), nn.LogSoftmax(dim=-1)),
    "Attention": Attention,
    "Two views": TwoViews,
    "GLU": lambda: nn.Sequential(
        nn.Flatten(), nn.Linear(RAYS, HIDDEN), nn.GLU(), nn.Linear(HIDDEN // 2, ACTIONS)
    ),
}
RECURRENT: dict[str, Callable[[], nn.Module]] = {
    "GRU cell": lambda: Remembering("GRU"),
    "LSTM cell": lambda: Remembering("LSTM"),
}
ARCHITECTURES: dict[str, Callable[[], nn.Module]] = {
    **{f"MLP, {name}": lambda made=made: layers(made) for name, made in ACTIVATIONS.items()},  # type: ignore[misc]  # each has its own default
    **STRUCTURES,
    **RECURRENT,
}


def network(name: str, gain: float = 1.0, seed: int = 0) -> nn.Module:
    """A network of random weights, multiplied by a gain; statistics of a norm are drawn too."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        module = ARCHITECTURES[name]()
        with torch.no_grad():
            for parameter in module.parameters():
                parameter.mul_(gain)
            for part in module.modules():
                if isinstance(part, nn.BatchNorm1d):
                    assert part.running_mean is not None
                    assert part.running_var is not None
                    part.running_mean.normal_(0.0, gain)
                    part.running_var.uniform_(0.1, 2.0).mul_(gain)
    return module


def contract_of(name: str) -> PolicyContract:
    """The contract that fits it."""
    sizes = {"GRU cell": 8, "LSTM cell": 16}
    return PolicyContract(state=StateSpec(sizes[name])) if name in sizes else PolicyContract()
