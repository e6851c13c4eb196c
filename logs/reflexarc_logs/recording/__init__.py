"""Recording to a log, in a thread of its own that never blocks the loop."""
