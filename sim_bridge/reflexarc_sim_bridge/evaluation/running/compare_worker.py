"""A worker of comparisons: `python -m reflexarc_sim_bridge.evaluation.running.compare_worker`."""

import sys
from typing import Any

from reflexarc_runtime.errors import ReflexarcError, UsageError, first_line
from reflexarc_sim_bridge.crew.worker import serve
from reflexarc_sim_bridge.evaluation.running.compare import Comparison


def main() -> None:
    """Do comparisons until the input ends."""
    serve(_do, "comparisons")


def _do(plain: dict[str, Any]) -> dict[str, Any]:
    """A comparison; `path` are the places where its parent finds modules."""
    sys.path += [place for place in plain["path"] if place not in sys.path]
    try:
        looks = Comparison.from_plain(plain["comparison"]).looks()
    except ReflexarcError:
        raise
    except Exception as error:  # somebody else's code decides
        raise UsageError(f"it raised {type(error).__name__}: {first_line(error)}") from error
    return {"looks": [[look.log_ratio, look.error] for look in looks]}


if __name__ == "__main__":
    main()
