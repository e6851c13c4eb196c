"""Asking the memory for an agent's near lists while another one is still at work.

Thousands of agents have megabytes of them, each read for the first time at every step. They are
short rows in many places, which a processor does not foresee by itself. It can have about
a dozen such reads under way, and a further one waits; so they come in two halves, one before an
agent moves and one before it looks.
"""

from reflexarc_sim_bridge.arrays.layout import BOXES, DISCS, TURNED, Floats32, Params
from reflexarc_sim_bridge.native.decorators import compiled_inline, compiled_part
from reflexarc_sim_bridge.native.intrinsics import LANES, fetch


@compiled_part
def foresee(params: Params, i: int, half: int) -> None:
    """Ask for every other row of agent `i`'s near lists, from row `half` on: 0 or 1.

    Not for sides, whose rows are long enough to be foreseen.
    """
    agents = params.agents
    for number in range(agents.near_counts.shape[1]):
        counts = agents.near_counts[i, number]
        _ask_for(agents.boxes[i, number], counts[BOXES], half)
        _ask_for(agents.turned[i, number], counts[TURNED], half)
        _ask_for(agents.discs[i, number], counts[DISCS], half)


@compiled_inline
def _ask_for(near: Floats32, count: int, half: int) -> None:
    """A line of the cache holds `LANES` columns of a row."""
    for row in range(half, near.shape[0], 2):
        for k in range(0, count, LANES):
            fetch(near[row], k)
