"""Moments of a log, rebuilt in the world that it was driven in, and driven on."""
