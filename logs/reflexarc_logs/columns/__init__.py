"""The ticks of a log as arrays: what thousands of them have in common is read once."""
