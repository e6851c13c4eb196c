"""What a machine can promise a loop: measured, then judged."""
