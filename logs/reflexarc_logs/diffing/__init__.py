"""Any two logs, ours or not, compared topic by topic and field by field."""
