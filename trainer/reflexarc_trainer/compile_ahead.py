"""A learner's code is compiled by a second process while this one compiles its world.

That is done once for each state of the sources, and takes either of them many seconds of one
processor.
"""

import json
import sys

import numpy as np

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.compile_cache import compiling_alone, is_kept
from reflexarc_sim_bridge.lean import uncollected
from reflexarc_sim_bridge.second_process import at_work, end_with_parent, has_room
from reflexarc_sim_bridge.simulation import Simulation
from reflexarc_trainer import batched_learner, online_learner
from reflexarc_trainer.config import TrainConfig

_WORLD = "kernel.advance"
_LEARNERS = {"batched": "batched.learn", "online": "online_learner.drive"}


def compile_side_by_side(config: TrainConfig) -> None:
    """Compile the learner of a run, and its world meanwhile, unless that is done.

    Raises:
        WorldError: there is no such world, or it cannot give what the eye asks for.
    """
    if _is_worth_it(config):
        with at_work(__name__, json.dumps(config.resolved()).encode()):
            Simulation(config.worlds[0].source(), config.contract(), np.zeros(1, np.uint64))
    if not is_kept(_LEARNERS[config.learner.form]):
        compile_learner(config)


def compile_learner(config: TrainConfig) -> None:
    """Compile the code that a run learns with, as no other process does: it learns for no step."""
    form = batched_learner if config.learner.form == "batched" else online_learner
    with compiling_alone(_LEARNERS[config.learner.form]), uncollected():
        form.compile_learner(config)


def _is_worth_it(config: TrainConfig) -> bool:
    return has_room() and not is_kept(_WORLD) and not is_kept(_LEARNERS[config.learner.form])


def main() -> None:
    """The other process: a resolved configuration comes in on standard input."""
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
