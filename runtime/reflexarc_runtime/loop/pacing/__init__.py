"""Pacers: when a tick begins, and with which messages."""
