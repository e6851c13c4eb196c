"""Replay: a log's inputs decided again, and compared field by field with what was recorded."""
