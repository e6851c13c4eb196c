"""A worker process of a suite: `python -m reflexarc_sim_bridge.evaluation.running.suite_worker`."""

import sys
from typing import Any

from reflexarc_runtime.crew.worker import serve
from reflexarc_sim_bridge.evaluation.running.doing import do_unit
from reflexarc_sim_bridge.evaluation.running.suite_unit import SuiteUnit, evaluation_code
from reflexarc_sim_bridge.native.threads import set_thread_count


def main() -> None:
    """Do units until the input ends."""
    set_thread_count(1)  # there is one worker per processor
    serve(_do, evaluation_code())


def _do(plain: dict[str, Any]) -> dict[str, Any]:
    """A unit; `path` are the places where its parent finds modules."""
    sys.path += [place for place in plain["path"] if place not in sys.path]
    return do_unit(SuiteUnit.from_plain(plain["unit"]))


if __name__ == "__main__":
    main()
