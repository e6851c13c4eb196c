"""Whether logs are sound: whole, without gaps, on clocks that run, and true when replayed."""
