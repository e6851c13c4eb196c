"""Who can come in: what a Zenoh configuration listens on, and why a TLS door stays shut."""
