"""The whole arc in one go: learn, measure, drive, record, replay, show."""
