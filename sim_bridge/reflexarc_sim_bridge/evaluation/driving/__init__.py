"""One contender drives through one cell, and what it did is written down step by step."""
