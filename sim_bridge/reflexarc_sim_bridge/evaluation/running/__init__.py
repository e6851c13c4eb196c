"""A suite shared among processes, kept unit by unit."""
