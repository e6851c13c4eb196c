"""What is physically possible: agents that see nothing, everything, or as far as an eye."""
