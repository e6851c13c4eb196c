"""Plays a log: sends its sensor streams again, at their times or in lockstep."""
