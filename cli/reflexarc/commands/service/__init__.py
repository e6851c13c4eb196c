"""Commands for robots in service: what a machine can promise, who is there, what they run."""
