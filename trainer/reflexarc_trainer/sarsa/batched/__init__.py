"""SARSA(λ) for many agents at once: roll-outs, λ-returns, gradient steps over minibatches."""
