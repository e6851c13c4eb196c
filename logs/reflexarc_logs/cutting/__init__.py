"""Cutting a log: a part of it becomes a log of its own, which replays."""
