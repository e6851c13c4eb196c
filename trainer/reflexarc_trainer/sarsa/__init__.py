"""SARSA(λ): the readable reference, and two compiled forms of it, `online` and `batched`."""
