"""The policy contract: the only definition of what a policy sees and does."""
