"""A log as a test: of this software, or of a candidate; why it fails; how a new one is accepted.

log_trial              one log, replayed or judged
failure_text           why it failed, in words that need no other file
tick_moment, shades    what was seen at a tick, and as a line of text
baseline               a new one is accepted; decided_anew and baseline_file make it
"""
