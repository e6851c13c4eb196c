"""A policy on a log of sensors alone, as the loop would have decided at its rate."""
