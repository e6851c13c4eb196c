"""The page of a run, in Markdown: its scores, its pictures, some of its policy's decisions."""

from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.arrays import RetinaBatch
from reflexarc_sim_bridge.worlds.world import World
from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.policy.provenance import commit, versions
from reflexarc_trainer.policy.q_network import QNetwork
from reflexarc_trainer.policy.weights import NetworkPolicy
from reflexarc_trainer.run.history import Row, best_of
from reflexarc_trainer.run.validation import drive_and_record

_BLOCKS = "·▁▂▃▄▅▆▇█"
_WIDEST = 64
"""Most rays of an eye that are shown."""


def write_report(network: QNetwork, config: TrainConfig, step: int, history: Sequence[Row]) -> str:
    """The page; it shows the pictures that lie in the same folder.

    Args:
        network: the learned network.
        config: the run that learned it.
        step: transitions that it learned from.
        history: the validation points.
    """
    parts = [
        f"# {config.preset}, seed {config.seed}",
        _figures(config, step, history),
        "![Contacts per 100 m over steps](curve.png)",
        "![Share of the time at each lateral place](occupancy.png)",
        "## What it decides",
        "Retinas that it met while driving: for each action the one that it was surest of, and the "
        "closest call. Rays from left to right, brighter is higher, · is nothing; the winner is in "
        "bold.",
        _decisions(network, config),
        "## Where it comes from",
        _origin(config),
    ]
    return "\n\n".join(parts) + "\n"


def _figures(config: TrainConfig, step: int, history: Sequence[Row]) -> str:
    rows = [("learned from", f"{step:,} of {config.steps:,} steps")]
    best, last = best_of(history), history[-1] if history else None
    if best is not None and last is not None:
        rows += [
            ("`policy.onnx`, the last", _point(last)),
            ("`policy-best.onnx`, the best by validation", _point(best)),
            ("learning, validation and all", f"{last.seconds:.1f} s"),
        ]
    world = config.goal_world
    blind = world.blind_contacts_per_100m if isinstance(world, World) else None
    if blind is not None:
        rows.append(("never steering", f"{blind:.1f} contacts per 100 m"))
    return _table(("", ""), rows)


def _point(row: Row) -> str:
    score = row.validation_contacts_per_100m
    return f"{score:.2f} contacts per 100 m on validation worlds, after {row.step:,} steps"


def _origin(config: TrainConfig) -> str:
    worlds = ", then ".join(f"`{world.name}` (share {world.share:g})" for world in config.worlds)
    packages = ", ".join(f"{name} {version}" for name, version in versions().items())
    rows = [
        ("worlds", worlds),
        ("learner", f"{config.learner.form}, {_network(config)}"),
        ("begun with the weights of", f"`{config.init_from or 'none: new ones'}`"),
        ("configuration", f"`{config.hash}` (`config.json`)"),
        ("commit", f"`{commit() or 'unknown'}`"),
        ("versions", packages),
    ]
    return _table(("", ""), rows)


def _network(config: TrainConfig) -> str:
    contract = config.contract()
    inputs = contract.retina.frames * contract.retina.size
    return "–".join(map(str, (inputs, *config.network.hidden, len(contract.actions))))


def _decisions(network: QNetwork, config: TrainConfig) -> str:
    retinas, names = drive_and_record(network, config), _action_names(config)
    q_values, actions = NetworkPolicy(network).decide(retinas)
    chosen = examples(q_values, actions)
    rows = []
    for i in chosen:
        values = [f"{q:.3f}" for q in q_values[i]]
        values[actions[i]] = f"**{values[actions[i]]}**"
        rows.append((_picture(retinas[i]), *values))
    return _table(("retina", *names), rows)


def examples(q_values: npt.NDArray[np.float32], actions: npt.NDArray[np.int64]) -> list[int]:
    """Decisions to show: for each action the one with the largest margin; then the closest call.

    The margin is the difference of the two largest Q-values.

    Args:
        q_values: (n, actions).
        actions: the greedy actions: (n,).

    Returns:
        Indices of decisions: one for each action that occurs, in their order, and the closest call.
    """
    ordered = np.sort(q_values, axis=1)
    margins = ordered[:, -1] - ordered[:, -2]
    surest = [
        int(np.where(actions == action, margins, -1.0).argmax())
        for action in range(q_values.shape[1])
        if (actions == action).any()
    ]
    return [*surest, int(margins.argmin())]


def _action_names(config: TrainConfig) -> tuple[str, ...]:
    return tuple(action.name for action in config.contract().actions)


def _picture(stack: RetinaBatch) -> str:
    """The newest retina of a stack (frames, eyes, rays, channels) as bars, eye after eye."""
    eyes = stack[-1].mean(axis=-1)[:, :_WIDEST]
    return " ".join(f"`{''.join(_bar(value) for value in eye)}`" for eye in eyes)


def _bar(value: float) -> str:
    return _BLOCKS[min(int(value / 256.0 * len(_BLOCKS)), len(_BLOCKS) - 1)]


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
