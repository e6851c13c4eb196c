"""A worker process, which does units of a study: `python -m reflexarc_trainer.study.worker`."""

import dataclasses
from typing import Any

import torch

from reflexarc_runtime.crew.worker import serve
from reflexarc_sim_bridge.native.threads import set_thread_count
from reflexarc_trainer.study.measuring import measure
from reflexarc_trainer.study.unit import Unit, code_key


def main() -> None:
    """Do units until the input ends."""
    torch.set_num_threads(1)
    set_thread_count(1)  # there is one worker per processor
    serve(_do, code_key())


def _do(plain: dict[str, Any]) -> dict[str, Any]:
    return dataclasses.asdict(measure(Unit.from_plain(plain)))


if __name__ == "__main__":
    main()
