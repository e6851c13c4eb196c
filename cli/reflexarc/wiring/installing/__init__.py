"""What a service may read and write, looked at before its unit is written."""
