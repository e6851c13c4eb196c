"""A sensor, a brain and a body, the same three in each framework, each a process of its own."""
