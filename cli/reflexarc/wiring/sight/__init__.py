"""Seeing robots: who listens to all of them, and who answers the scrapes of their metrics."""
