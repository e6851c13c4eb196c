"""What a command records, how it is kept, and what became of it."""
