"""A robot's body on the bus: publishes its senses, obeys commands, stops when it hears none."""
