"""The earlier systems that the paper names, rebuilt from their sources."""
