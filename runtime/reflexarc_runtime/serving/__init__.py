"""Several policies in one loop: one takes over from another, and one only watches."""
