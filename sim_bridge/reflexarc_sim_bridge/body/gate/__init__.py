"""The last gate before a motor: whom a body obeys, when, and how fast at most."""
