"""A worker of `make limits`: it computes the units of `shipping.py`, one by one."""

from typing import Any

from reflexarc_runtime.crew.worker import serve
from reflexarc_sim_bridge.evaluation.limits import kept
from reflexarc_sim_bridge.evaluation.limits.shipping import compute, units_to_ship
from reflexarc_sim_bridge.native.threads import set_thread_count


def main() -> None:
    """Compute units until the input ends."""
    kept.shipped_figures = dict  # type: ignore[assignment]  # what ships is not asked
    set_thread_count(1)  # there is one worker per processor
    serve(_do, "limits")


def _do(plain: dict[str, Any]) -> dict[str, Any]:
    """The unit of this place in the list, which is the same in every process."""
    key, figures = compute(units_to_ship()[plain["unit"]])
    return {"key": key, "figures": figures}


if __name__ == "__main__":
    main()
