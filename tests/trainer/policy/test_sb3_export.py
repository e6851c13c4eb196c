"""Models of Stable-Baselines3 by one call; the tests of the library itself skip where it is not."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import torch
from gymnasium import Env, spaces
from torch import Tensor, nn

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_trainer.policy.sb3_export import export_sb3

CONTRACT = PolicyContract()
RETINAS = np.random.default_rng(6).integers(0, 256, (300, 1, 1, 16, 1), np.uint8)


class LikeDqn:
    """What `export_sb3` looks at of a DQN, without the library."""

    def __init__(self, space: spaces.Space[Any], actions: spaces.Space[Any], flips: bool) -> None:
        torch.manual_seed(1)
        layers = nn.Sequential(nn.Linear(16, 8), nn.Tanh(), nn.Linear(8, 3))
        net = SimpleNamespace(features_extractor=nn.Flatten(), q_net=layers)
        self.policy = SimpleNamespace(q_net=net, normalize_images=True)
        self.observation_space, self.action_space, self._flips = space, actions, flips

    def get_vec_normalize_env(self) -> None:
        return None

    def predict(self, seen: Any, deterministic: bool) -> tuple[Any, None]:
        assert deterministic
        seen = seen[:, ::-1].copy() if self._flips else seen
        net = self.policy.q_net
        with torch.no_grad():
            values = net.q_net(net.features_extractor(torch.from_numpy(seen).float()))
        return values.numpy().argmax(axis=1), None


BYTES = spaces.Box(0, 255, (16,), np.uint8)
SHARES = spaces.Box(0.0, 1.0, (1, 1, 16, 1), np.float32)
THREE = spaces.Discrete(3)


def like_dqn(
    space: spaces.Space[Any] = BYTES, actions: spaces.Space[Any] = THREE, flips: bool = False
) -> Any:
    return LikeDqn(space, actions, flips)


@pytest.mark.parametrize("space", [BYTES, SHARES], ids=["bytes", "shares"])
def test_a_model_decides_in_the_file_as_it_does_itself(space: spaces.Box, tmp_path: Path) -> None:
    model, path = like_dqn(space), tmp_path / "p.onnx"
    export_sb3(model, CONTRACT, str(path))
    seen = RETINAS.reshape(len(RETINAS), *space.shape)
    seen = seen if space.dtype == np.uint8 else seen.astype(np.float32) / 255
    winners, _ = model.predict(seen, deterministic=True)
    for backend in ("numpy", "onnxruntime"):
        assert np.array_equal(load_policy(path, backend).decide(RETINAS)[1], winners)


class Mirrored(nn.Module):
    """Shows the rays from the right to the left, as bytes."""

    def forward(self, x: Tensor) -> Tensor:
        x = torch.flatten(x, 1) * 255
        return torch.cat([x[:, place : place + 1] for place in reversed(range(16))], dim=1)


def test_observations_of_ones_own_are_said(tmp_path: Path) -> None:
    model, path = like_dqn(), tmp_path / "p.onnx"
    export_sb3(model, CONTRACT, path, observe=Mirrored())
    seen = RETINAS.reshape(-1, 16)[:, ::-1].copy()
    winners, _ = model.predict(seen, deterministic=True)
    assert np.array_equal(load_policy(path).decide(RETINAS)[1], winners)


@pytest.mark.parametrize(
    ("model", "said"),
    [
        (nn.Linear(16, 3), "exported by reflexarc.export"),
        (like_dqn(actions=spaces.Box(-1.0, 1.0, (2,))), "one value an action"),
        (like_dqn(actions=spaces.Discrete(3, start=1)), "counted from 0"),
        (like_dqn(actions=spaces.Discrete(5)), "has 5 actions, the contract 3 "),
        (like_dqn(spaces.Box(0, 255, (32,), np.uint8)), "32 values .* retina 16"),
        (like_dqn(spaces.Box(-1.0, 1.0, (16,))), "say how a retina becomes one: observe="),
        (like_dqn(spaces.Dict({"rays": BYTES})), "say observe="),
        (like_dqn(flips=True), "retinas the model itself decides otherwise"),
    ],
)
def test_what_cannot_be_exported_is_refused_in_one_line(
    model: Any, said: str, tmp_path: Path
) -> None:
    with pytest.raises(PolicyError, match=said) as refusal:
        export_sb3(model, CONTRACT, tmp_path / "p.onnx")
    assert "\n" not in str(refusal.value)
    assert not list(tmp_path.iterdir())


class Drawn(Env[Any, Any]):
    """Shows anything, and rewards the second action."""

    action_space = THREE

    def __init__(self, space: spaces.Box) -> None:
        self.observation_space = space

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        super().reset(seed=seed)
        return self.observation_space.sample(), {}

    def step(self, action: Any) -> Any:
        return self.observation_space.sample(), float(action == 1), False, False, {}


@pytest.mark.long
@pytest.mark.parametrize("algorithm", ["PPO", "A2C", "DQN"])
@pytest.mark.parametrize("normalises", [False, True])
def test_the_library_s_models_decide_in_the_file_as_they_do_themselves(
    algorithm: str, normalises: bool, tmp_path: Path
) -> None:
    library = pytest.importorskip("stable_baselines3")
    from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

    env = DummyVecEnv([lambda: Drawn(BYTES)])
    if normalises:
        env = VecNormalize(env)
        env.reset()
        for _ in range(100):
            env.step(np.array([0]))
    model = getattr(library, algorithm)("MlpPolicy", env, seed=2, device="cpu")
    export_sb3(model, CONTRACT, tmp_path / "p.onnx")
    seen = RETINAS.reshape(-1, 16)
    seen = env.normalize_obs(seen) if normalises else seen
    winners, _ = model.predict(seen, deterministic=True)
    assert np.array_equal(load_policy(tmp_path / "p.onnx").decide(RETINAS)[1], winners)
