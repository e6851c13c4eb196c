"""One picture of one log: the path, what the policy saw, what it decided."""
