"""Logs and live robots in a viewer: what each message becomes, and Rerun, which draws it."""
