"""Commands on logs: record, play, replay, render, import, recover, info."""
