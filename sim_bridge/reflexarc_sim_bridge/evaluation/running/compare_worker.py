"""A worker of comparisons: `python -m reflexarc_sim_bridge.evaluation.running.compare_worker`."""

import sys
from typing import Any

from reflexarc_runtime.crew.worker import serve
from reflexarc_sim_bridge.evaluation.protocol.foreign_code import foreign_code
from reflexarc_sim_bridge.evaluation.running.compare import Comparison
from reflexarc_sim_bridge.native.threads import set_thread_count


def main() -> None:
    """Do comparisons until the input ends."""
    set_thread_count(1)  # there is one worker per processor
    serve(_do, "comparisons")


def _do(plain: dict[str, Any]) -> dict[str, Any]:
    """A comparison; `path` are the places where its parent finds modules."""
    sys.path += [place for place in plain["path"] if place not in sys.path]
    with foreign_code():
        looks = Comparison.from_plain(plain["comparison"]).looks()
    return {"looks": [[look.log_ratio, look.error] for look in looks]}


if __name__ == "__main__":
    main()
