"""What `reflexarc demo` does: learn, measure, drive, record, replay, show."""
