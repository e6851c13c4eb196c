"""Records of a damaged file: where they begin, of what kind they are, and where they end."""
