"""A log's sensor streams sent out again, at their times or in lockstep."""
