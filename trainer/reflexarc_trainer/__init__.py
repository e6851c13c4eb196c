"""LEARNS: network, SARSA(λ), training, export.

Start reading at `reference.py` (the algorithm) and `train.py` (a run); a file a concept:

    config presets schedules history           what a run is made of
    q_network reference                        torch: the network, the algorithm to be read
    choice online learner weights              compiled: the same algorithm, the world inside
    validation train checkpoint curve          a run and what it leaves
    export translate parity delivery provenance   the policy file

Importing the package loads neither torch nor numba; the modules do.
"""
