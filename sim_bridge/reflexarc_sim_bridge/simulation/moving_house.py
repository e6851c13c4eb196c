"""One agent moves house: into a simulation of the same world that has another eye or other motions.

It keeps its place, heading, speed, way and contacts, the time of what moves in its world, and its
stream of random numbers. What it saw it forgets: that was seen by another eye.
"""

from reflexarc_sim_bridge.simulation.putting import settle
from reflexarc_sim_bridge.simulation.simulation import Simulation


def move_house(agent: Simulation, former: Simulation) -> None:
    """Put the first agent of a simulation where that of another one is, as if it always was there.

    Args:
        agent: a new simulation of the same world and seed; its step may have another duration.
        former: where the agent has been.
    """
    looks = agent.params.agents.state["looks"][0]
    here = former.params.agents.state[0].copy()
    here["looks"] = looks
    here["steps"] = round(int(here["steps"]) * former.dt_s / agent.dt_s)
    settle(agent, here)
