"""Policies that shall take over in a running loop, and policies that only watch it."""
