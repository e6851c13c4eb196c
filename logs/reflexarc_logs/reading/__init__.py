"""Reading a log: its messages, its summary, what can be recovered of a damaged one."""
