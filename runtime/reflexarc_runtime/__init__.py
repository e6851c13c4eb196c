"""ACTS: the contract, the policy and the sense–act loop. Imports no other room, and no torch."""
