"""The sense–act loop: its clock, pace, inbox, statistics, and the watchdog on the body's side."""
