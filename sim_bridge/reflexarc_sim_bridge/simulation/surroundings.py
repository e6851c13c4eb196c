"""How much room the agents of a simulation have: around each, and straight ahead of it.

    from reflexarc_sim_bridge.simulation.surroundings import AgentSurroundings

    surroundings = AgentSurroundings(simulation)      # a Simulation(…, all_round=True)
    surroundings.measure(clearance_m, ahead_s)   # fills two float32 arrays: (n,)

Nothing is disturbed by it, and only who asks for it compiles it. The same agents give the same bits
on any number of threads.
"""

from functools import partial
from threading import get_ident

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.native.struct_pointers import Struct
from reflexarc_sim_bridge.native.threads import shared
from reflexarc_sim_bridge.simulation.simulation import Simulation, motions_of
from reflexarc_sim_bridge.simulation.step import call_survey
from reflexarc_sim_bridge.simulation.step_compilation import survey_for

Floats32 = npt.NDArray[np.float32]


class AgentSurroundings:
    """What is around the agents of a simulation.

    Args:
        simulation: with near lists all round, else what lies behind an agent would be missing.
        forward_mps: how fast an agent would go straight on; None: as the first action does.
    """

    def __init__(self, simulation: Simulation, forward_mps: float | None = None) -> None:
        contract = simulation.contract
        self._simulation = simulation
        self._range_m = contract.retina.range_m
        is_around = simulation.params.world.planes["behind_m"].min() >= self._range_m
        assert is_around, "AgentSurroundings: expected a Simulation(…, all_round=True)"
        first_mps = contract.actions[0].linear_mps
        self._forward_mps = float(first_mps if forward_mps is None else forward_mps)
        self._survey = survey_for(simulation.params, motions_of(contract))
        self._held: dict[int, Struct] = {}  # one a thread

    def measure(self, clearance_m: Floats32, ahead_s: Floats32) -> None:
        """Fill in what each agent has now.

        Args:
            clearance_m: from its outline to the nearest obstacle; 0 in contact; what is farther
                from its middle than the eye's range counts as being there: (n,).
            ahead_s: time up to the first contact if it went straight on along its heading, of what
                lies within the range now; 0 in contact, infinity if there is none: (n,).
        """
        shared(partial(self._measure, clearance_m, ahead_s), len(self._simulation))

    def _measure(self, clearance_m: Floats32, ahead_s: Floats32, first: int, end: int) -> None:
        thread = get_ident()
        if thread not in self._held:
            self._held[thread] = self._simulation.held_step()[1]
        speed_mps, range_m = self._forward_mps, self._range_m
        held = self._held[thread]
        call_survey(self._survey, held, speed_mps, range_m, clearance_m, ahead_s, first, end)
