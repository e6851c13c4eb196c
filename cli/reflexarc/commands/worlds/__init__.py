"""Commands on worlds: list, show, check."""
