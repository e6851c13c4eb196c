"""LEARNS: network, SARSA(λ), training, export.

Start reading at `sarsa/reference.py` (the algorithm) and `run/train.py` (a run).

    config/    what defines a run: its dataclasses, the presets, the worlds to learn in
    sarsa/     the algorithm: a reference in torch, and two compiled forms
    policy/    the network in torch, and as a policy file: export, check, warm start
    run/       one run: the training loop, validation, checkpoints, the folder with its results
    study/     many runs: a grid of configurations × seeds, and what they show together

Importing the package loads neither torch nor numba; its modules do.
"""
