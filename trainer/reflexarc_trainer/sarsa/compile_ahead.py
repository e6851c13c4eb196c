"""Compilation before a run: a second process compiles the learner, this one its world meanwhile.

Either takes many seconds of one processor, once for each state of the sources; later runs load the
machine code from the cache.
"""

import json
import sys
from contextlib import AbstractContextManager, nullcontext
from typing import Any

import numpy as np

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.native.cache import compiling_alone, is_kept
from reflexarc_sim_bridge.native.helper_process import at_work, end_with_parent, has_room
from reflexarc_sim_bridge.native.lean import uncollected
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.simulation.step import advance
from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.sarsa.batched import learner as batched_learner
from reflexarc_trainer.sarsa.batched.update import learn
from reflexarc_trainer.sarsa.online import learner as online_learner
from reflexarc_trainer.sarsa.online.update import drive

_compiled: set[tuple[str, str, str]] = set()
"""Form and precisions of the learners that this process has compiled or loaded: all that the types
of compiled code depend on."""
_LEARNERS: dict[str, Any] = {"batched": learn, "online": drive}
"""The compiled function of each form; where the cache has it, it has its parts too."""


def compile_side_by_side(config: TrainConfig) -> None:
    """Compile the learner of a run and, at the same time, its world; do nothing if both are.

    Raises:
        WorldError: the world does not exist, or does not support the eye.
    """
    form = config.learner.form, config.learner.batched.precision, config.learner.online.precision
    if form in _compiled:
        return
    with _helped(config):
        Simulation(config.worlds[0].source(), config.contract(), np.zeros(1, np.uint64))
    compile_learner(config)
    _compiled.add(form)


def _helped(config: TrainConfig) -> AbstractContextManager[None]:
    """A context in which a second process compiles the learner, if both are to be compiled."""
    is_worth_it = (
        has_room() and not is_kept(advance) and not is_kept(_LEARNERS[config.learner.form])
    )
    if not is_worth_it:
        return nullcontext()
    return at_work(__name__, json.dumps(config.resolved()).encode())


def compile_learner(config: TrainConfig) -> None:
    """Compile the learner of a run, or wait for the process that is compiling it."""
    form = batched_learner if config.learner.form == "batched" else online_learner
    with compiling_alone(_LEARNERS[config.learner.form].__qualname__), uncollected():
        form.compile_learner(config)


def main() -> None:
    """The second process: standard input gives a resolved configuration as JSON."""
    try:
        config = TrainConfig.from_resolved(json.load(sys.stdin))
    except (ValueError, UsageError) as error:
        print(
            f"compile_ahead: expected a configuration on standard input: {error}", file=sys.stderr
        )
        raise SystemExit(2) from None
    end_with_parent()
    compile_learner(config)


if __name__ == "__main__":
    main()
