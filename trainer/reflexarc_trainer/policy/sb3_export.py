"""A trained model of Stable-Baselines3 as a policy file: PPO, A2C, DQN and their kind.

What such a model decides by lies in several places, which are put together here:

    retina → observation (bytes or [0, 1]) → VecNormalize → features → layers → logits or Q-values

The largest value wins, as in `model.predict(…, deterministic=True)`, with which the result is
compared before anything is written. The library itself is not needed: only the model's attributes
are looked at.
"""

from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from reflexarc_runtime.arrays import RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.sensing.ray_values import FULL_SCALE
from reflexarc_trainer.policy.export import export
from reflexarc_trainer.policy.probes import probe_retinas

_CLOSE = 1e-3
"""Share of the usual spread of the values, below which another winner is rounding."""
_IMAGE_AXES = 3
_DISCRETE = "expected a model with one value an action (PPO, A2C, DQN with discrete actions)"


def export_sb3(
    model: Any,
    contract: PolicyContract,
    path: Path | str,
    *,
    observe: nn.Module | None = None,
    vec_normalize: Any = None,
    recorded: RetinaBatch | None = None,
) -> PolicyContract:
    """Write a model of Stable-Baselines3 as a policy file.

    Args:
        model: a trained model: PPO, A2C or DQN with discrete actions.
        contract: what it saw and did while it learned: its eye, its actions in their order.
        path: the file.
        observe: how retinas, floats in [0, 1] (n, frames, eyes, rays, channels), became what the
            model was given, before `VecNormalize`. Not needed where the observations were the
            retina in its order, flat or not, as bytes (0 to 255) or as floats in [0, 1].
        vec_normalize: the `VecNormalize` that it learned behind; by default the model's own.
        recorded: retinas of a drive, to check beside random ones.

    Returns:
        The contract as written, golden vectors included.

    Raises:
        PolicyError: it is no such model, its observations or actions are not those of the
            contract, or the file would not decide as the model does. Nothing is written.
    """
    _check_actions(model, contract)
    normal = vec_normalize or model.get_vec_normalize_env()
    observed = observe or _bytes_or_shares(model, normal, contract)
    inside = nn.Sequential(_normalised(normal), _as_image(model), _network(model.policy))
    module = nn.Sequential(observed, inside)
    module.float().eval()
    _check_decisions(model, module, observed, normal, probe_retinas(contract, recorded))
    return export(module, contract, Path(path), recorded=recorded)


class _Scaled(nn.Module):
    """The observations of an environment that shows the retina itself: (n, *shape)."""

    def __init__(self, scale: float, shape: tuple[int, ...]) -> None:
        super().__init__()
        self.scale, self.shape = scale, shape

    def forward(self, x: Tensor) -> Tensor:
        x = torch.reshape(x, (-1, *self.shape))
        return x if self.scale == 1.0 else x * self.scale


class _Shares(nn.Module):
    """Bytes of an image as shares of 255."""

    def forward(self, x: Tensor) -> Tensor:
        return x / FULL_SCALE


class _Normalised(nn.Module):
    """Observations less their mean, over their deviation, cut off: `VecNormalize`."""

    mean: Tensor
    deviation: Tensor

    def __init__(self, vec_normalize: Any) -> None:
        super().__init__()
        seen = vec_normalize.obs_rms
        deviation = np.sqrt(seen.var + vec_normalize.epsilon)
        self.register_buffer("mean", torch.from_numpy(np.array(seen.mean)))
        self.register_buffer("deviation", torch.from_numpy(np.array(deviation)))
        self.most = float(vec_normalize.clip_obs)

    def forward(self, x: Tensor) -> Tensor:
        return torch.clamp((x - self.mean) / self.deviation, -self.most, self.most)


class _Actor(nn.Module):
    """The logits of PPO or A2C."""

    def __init__(self, policy: Any) -> None:
        super().__init__()
        self.features = getattr(policy, "pi_features_extractor", policy.features_extractor)
        self.layers, self.head = policy.mlp_extractor, policy.action_net

    def forward(self, x: Tensor) -> Tensor:
        logits: Tensor = self.head(self.layers.forward_actor(self.features(x)))
        return logits


class _Quantiles(nn.Module):
    """The means of QR-DQN's quantiles."""

    def __init__(self, net: Any) -> None:
        super().__init__()
        self.layers = nn.Sequential(net.features_extractor, net.quantile_net)
        self.shape = (-1, int(net.n_quantiles), int(net.action_space.n))

    def forward(self, x: Tensor) -> Tensor:
        return torch.reshape(self.layers(x), self.shape).mean(dim=1)


def _network(policy: Any) -> nn.Module:
    """From observations to values, out of the parts that the kinds of policies have."""
    if hasattr(policy, "lstm_actor"):
        raise PolicyError(
            "export: a recurrent model of Stable-Baselines3 is not supported; export its network "
            "as a torch module with a state (docs/networks.md)"
        )
    if hasattr(policy, "action_net") and hasattr(policy, "mlp_extractor"):
        return _Actor(policy)
    if hasattr(policy, "q_net"):
        return nn.Sequential(policy.q_net.features_extractor, policy.q_net.q_net)
    if hasattr(policy, "quantile_net"):
        return _Quantiles(policy.quantile_net)
    raise PolicyError(f"export: {_DISCRETE}, got a policy {type(policy).__name__}")


def _check_actions(model: Any, contract: PolicyContract) -> None:
    if not all(hasattr(model, name) for name in ("policy", "predict", "action_space")):
        raise PolicyError(
            f"export: {_DISCRETE}, got {type(model).__name__}; a torch module is exported by "
            "reflexarc.export"
        )
    space = model.action_space
    count, start = getattr(space, "n", None), int(getattr(space, "start", 0))
    if not isinstance(count, int | np.integer) or start:
        raise PolicyError(f"export: {_DISCRETE}, counted from 0; got actions {space}")
    if count != len(contract.actions):
        names = ", ".join(action.name for action in contract.actions)
        raise PolicyError(
            f"export: the model has {count} actions, the contract {len(contract.actions)} ({names})"
        )


def _bytes_or_shares(model: Any, normal: Any, contract: PolicyContract) -> nn.Module:
    """What makes the model's observations of retinas, from the bounds of their space."""
    space = model.observation_space if normal is None else normal.venv.observation_space
    high, low, shape = (getattr(space, name, None) for name in ("high", "low", "shape"))
    if high is None or low is None or not shape:
        raise PolicyError(f"export: observations {space} are not supported; say observe=…")
    size = contract.retina.frames * contract.retina.size
    if int(np.prod(shape)) != size:
        raise PolicyError(
            f"export: the model's observations have {int(np.prod(shape))} values {tuple(shape)}, "
            f"the contract's retina {size} {contract.retina.stack_shape}; give the contract that "
            "it learned with, or say observe=…"
        )
    most = np.unique(high)
    if np.any(low != 0) or most.tolist() not in ([1.0], [FULL_SCALE]):
        raise PolicyError(
            f"export: expected observations from 0 to 255 or from 0 to 1, got {space}; say how a "
            "retina becomes one: observe=…, and vec_normalize=… if it learned behind one"
        )
    return _Scaled(float(most[0]), tuple(shape))


def _normalised(normal: Any) -> nn.Module:
    if normal is None or not normal.norm_obs:
        return nn.Identity()
    if isinstance(normal.obs_rms, dict):
        raise PolicyError("export: VecNormalize over a dictionary of observations is not supported")
    return _Normalised(normal)


def _as_image(model: Any) -> nn.Module:
    """What the model itself does with images: bytes of three axes."""
    space, divides = model.observation_space, getattr(model.policy, "normalize_images", False)
    is_image = len(space.shape) == _IMAGE_AXES and np.dtype(space.dtype) == np.uint8
    return _Shares() if is_image and divides else nn.Identity()


def _check_decisions(
    model: Any, module: nn.Module, observed: nn.Module, normal: Any, retinas: RetinaBatch
) -> None:
    """Refuse what would decide otherwise than the model itself."""
    pixels = torch.from_numpy(retinas).float() / FULL_SCALE
    try:
        with torch.no_grad():
            seen, values = observed(pixels).numpy(), module(pixels).double().numpy()
        seen = _as_given(model, normal, seen)
        chosen = np.asarray(model.predict(seen, deterministic=True)[0])
    except (RuntimeError, ValueError, TypeError, IndexError, AttributeError) as error:
        reason = " ".join(str(error).split())[:200]
        raise PolicyError(f"export: the model fails on retinas {retinas.shape}: {reason}") from None
    rows = np.arange(len(values))
    lost = values.max(axis=1) - values[rows, chosen]
    usual = float(np.median(np.ptp(values, axis=1)))
    wrong = int(np.sum(lost > _CLOSE * usual))
    if wrong:
        raise PolicyError(
            f"export: for {wrong} of {len(values)} retinas the model itself decides otherwise: "
            "its observations are not made as was assumed; say observe=… (and vec_normalize=…)"
        )


def _as_given(model: Any, normal: Any, seen: Any) -> Any:
    """Observations as the model is asked with: normalised, of its own shape and type."""
    space = model.observation_space
    seen = seen.reshape(len(seen), *space.shape)
    if normal is not None:
        return normal.normalize_obs(seen)  # which makes floats, whatever the space says
    return (np.rint(seen) if np.dtype(space.dtype).kind in "ui" else seen).astype(space.dtype)
