"""Compilation before a run: a second process compiles the learner, this one its world meanwhile.

Either takes many seconds of one processor, once for each state of the sources; later runs load the
machine code from the cache.
"""

import json
import sys
from contextlib import ExitStack
from typing import Any

import numpy as np

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.native.cache import compiling_alone, is_kept, is_shared, prepare
from reflexarc_sim_bridge.native.compile_progress import compilation
from reflexarc_sim_bridge.native.helper_process import at_work, end_with_parent, has_room
from reflexarc_sim_bridge.native.numba_compiler import without_garbage_collection
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
_EXPECTED_S = {"batched": 11.0, "online": 8.0}
"""Seconds that each takes to compile, on a machine of medium speed."""


def compile_side_by_side(config: TrainConfig) -> None:
    """Compile the learner of a run and, at the same time, its world; do nothing if both are.

    Raises:
        WorldError: the world does not exist, or does not support the eye.
    """
    form = config.learner.form, config.learner.batched.precision, config.learner.online.precision
    if form in _compiled:
        return
    learner = _LEARNERS[config.learner.form]
    parts = {} if is_kept(learner) else {"how it learns": _EXPECTED_S[config.learner.form]}
    with ExitStack() as helped:
        if parts and has_room() and is_shared() and not is_kept(advance):
            given = json.dumps(config.resolved()).encode()
            helped.enter_context(at_work(__name__, given))
        world = config.source_of(config.worlds[0])
        Simulation(world, config.contract(), np.zeros(1, np.uint64))
        with compilation(parts) as compiling, compiling.part("how it learns"):
            helped.close()  # waits for the second process
            compile_learner(config)
    _compiled.add(form)


def compile_learner(config: TrainConfig) -> None:
    """Compile the learner of a run, or wait for the process that is compiling it."""
    prepare()
    form = batched_learner if config.learner.form == "batched" else online_learner
    with compiling_alone("learner"), without_garbage_collection():
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
