"""The fleet for Prometheus: metrics out of what was heard, and who answers a scrape."""
