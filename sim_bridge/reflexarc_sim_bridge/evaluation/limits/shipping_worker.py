"""A worker of `make limits`: it computes the units of `shipping.py`, one by one."""

from typing import Any

from reflexarc_sim_bridge.crew.worker import serve
from reflexarc_sim_bridge.evaluation.limits import kept
from reflexarc_sim_bridge.evaluation.limits.shipping import compute, units_to_ship


def main() -> None:
    """Compute units until the input ends."""
    kept.shipped_figures = dict  # type: ignore[assignment]  # what ships is not asked
    serve(_do, "limits")


def _do(plain: dict[str, Any]) -> dict[str, Any]:
    """The unit of this place in the list, which is the same in every process."""
    key, figures = compute(units_to_ship()[plain["unit"]])
    return {"key": key, "figures": figures}


if __name__ == "__main__":
    main()
