"""Logs as tables with one row a tick, for pandas, spreadsheets and databases."""
