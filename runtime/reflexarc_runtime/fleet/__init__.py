"""Every robot on a bus, as its own nodes tell: heard message by message, read off row by row."""
