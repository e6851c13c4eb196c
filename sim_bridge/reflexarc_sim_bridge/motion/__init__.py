"""How bodies move, what they touch, and where they may be placed."""
