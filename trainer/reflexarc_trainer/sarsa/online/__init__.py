"""SARSA(λ) for one agent: eligibility traces, an update after every transition."""
