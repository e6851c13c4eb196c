"""ACTS: runs a policy on a robot. Its contract, its file, the sense–act loop, the bus.

Imports no other package of this project, and no torch.
"""
