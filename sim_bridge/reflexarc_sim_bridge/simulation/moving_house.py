"""One agent moves house: into a simulation of the same world that has another eye or other motions.

It keeps its place, heading, speed, way and contacts, the time of what moves in its world, and its
stream of random numbers. What it saw it forgets: that was seen by another eye.
"""

from reflexarc_sim_bridge.simulation.simulation import Simulation

_NOWHERE = -(1 << 62)
"""No cell has this number: all near lists are made anew at the next step."""


def move_house(agent: Simulation, former: Simulation) -> None:
    """Put the first agent of a simulation where that of another one is, as if it always was there.

    Args:
        agent: a new simulation of the same world and seed; its step may have another duration.
        former: where the agent has been.
    """
    agents, looks = agent.params.agents, agent.params.agents.state["looks"][0]
    here = former.params.agents.state[0].copy()
    here["looks"] = looks
    here["steps"] = round(int(here["steps"]) * former.dt_s / agent.dt_s)
    agents.layer_cells[0], agents.near_counts[0] = _NOWHERE, 0
    # A step on the spot, among nothing, lists what is near; it is undone but for that.
    agents.state[0] = here
    for speed in ("linear_mps", "lateral_mps", "angular_radps"):
        agents.state[speed][0] = 0.0
    agents.state["steps"][0] -= 1
    agent.drive(0.0, 0.0, 0.0)
    agents.state[0] = here
