"""LEARNS: network, SARSA(λ), training, export.

Start reading at `reference.py` (the algorithm) and `train.py` (a run); a file a concept:

    config learner_config presets schedules history    what a run is made of
    q_network reference                       torch: the network, the algorithm to be read
    online online_state online_weights traces compiled, one agent: traces, an update a step
    batched rollout returns block optimiser   compiled, many agents: λ-returns, gradients
    choice units exponential rows fused       what both of them use
    learner forms online_learner batched_learner          their faces in Python
    initial_weights weights                   vectors of weights, and networks
    validation train checkpoint curve          a run and what it leaves
    study/ statistics edge_index              many runs: a grid × seeds, what they say together
    export translate parity delivery provenance   the policy file

Importing the package loads neither torch nor numba; the modules do.
"""
