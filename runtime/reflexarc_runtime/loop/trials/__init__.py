"""A policy file, and the contract in one that somebody sent, tried in a process of their own."""
