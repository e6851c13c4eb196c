"""SARSA(λ): a reference that is made to be read, and two compiled forms, `online` and `batched`.

forms compile_ahead                             which form a run has; its compilation
reference                                       the algorithm in torch, one visible update
online/                                         one agent: traces, an update per transition
batched/                                        many agents: roll-outs, λ-returns, Adam
learner_interface                               what a run knows of a learner of either form
network_shape units exponential initial_weights the network: sizes, activations, first weights
exploration schedules step_rules                ε-greedy choice, decaying ε and α, constants
"""
