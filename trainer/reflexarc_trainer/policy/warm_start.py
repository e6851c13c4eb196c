"""Warm start: initial weights of a run, taken from a policy file.

The policy must have the eye, the actions and the network of the run. Whether the network is the
same is tested: with these weights it must compute the policy's own Q-values.
"""

from pathlib import Path

import numpy as np
import numpy.typing as npt
import onnx
from onnx import numpy_helper

from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.policy.policy import LoadedPolicy, load_policy
from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.policy.parity import NUMPY_TOLERANCE
from reflexarc_trainer.policy.torch_parity import torch_decide
from reflexarc_trainer.policy.weights import unpack
from reflexarc_trainer.sarsa.network_shape import layers_for

_TRIED_RETINAS = 64
"""Random retinas for which the Q-values are compared."""


def weights_of(path: Path, config: TrainConfig) -> tuple[npt.NDArray[np.float64], str]:
    """Weights and SHA-256 of a policy file.

    Args:
        path: the file.
        config: the run that begins with the weights.

    Returns:
        The file's weights in the order of `weights.py`: (parameters,); and its hash.

    Raises:
        PolicyError: the file is not a policy, or damaged.
        UsageError: its eye, actions or network are not those of the run.
    """
    policy = load_policy(path, bounds=None)
    _check_contract(path, policy, config)
    weights = _gathered(policy.data)
    wanted, got = layers_for(config.network, config.contract()).parameters, weights.size
    if got != wanted:
        raise _other_network(path, config, f"{got} weights where {wanted} are needed")
    _check_values(path, policy, weights, config)
    return weights, policy.policy_hash


def _check_contract(path: Path, policy: LoadedPolicy, config: TrainConfig) -> None:
    mine, its = config.contract(), policy.contract
    for what, expected, got in (
        ("an eye of", _eye(mine.retina), _eye(its.retina)),
        ("actions", _names(mine.actions), _names(its.actions)),
    ):
        if expected != got:
            raise UsageError(f"init-from: {path}: expected {what} {expected}, got {got}")


def _eye(spec: RetinaSpec) -> str:
    return f"{spec.frames} x {spec.eyes} x {spec.rays} x {spec.channels} values"


def _names(actions: tuple[Action, ...]) -> str:
    return ", ".join(action.name for action in actions)


def _gathered(data: bytes) -> npt.NDArray[np.float64]:
    """W and b of every fully connected layer, in their order: (parameters,)."""
    graph = onnx.load_from_string(data).graph
    constants = {tensor.name: numpy_helper.to_array(tensor) for tensor in graph.initializer}
    names = [name for node in graph.node if node.op_type == "Gemm" for name in node.input[1:]]
    parts = [constants[name].astype(np.float64).ravel() for name in names if name in constants]
    return np.concatenate([np.empty(0), *parts])


def _check_values(
    path: Path, policy: LoadedPolicy, weights: npt.NDArray[np.float64], config: TrainConfig
) -> None:
    network, shape = unpack(weights, config.contract(), config.network), policy.contract.retina
    retinas = np.random.default_rng(0).integers(
        0, 256, (_TRIED_RETINAS, *shape.stack_shape), np.uint8
    )
    apart = np.abs(torch_decide(network, retinas)[0] - policy.decide(retinas)[0])
    if not np.all(apart <= NUMPY_TOLERANCE):
        raise _other_network(path, config, f"its Q-values differ by up to {float(apart.max()):.2g}")


def _other_network(path: Path, config: TrainConfig, reason: str) -> UsageError:
    network = config.network
    wanted = (
        f"{'-'.join(map(str, network.hidden))} hidden units ({network.units}), {network.output} "
        f"outputs, input power {network.input_power}"
    )
    return UsageError(
        f"init-from: {path}: expected a network of {wanted}, got another one ({reason}); "
        "choose the preset that it was learned with"
    )
