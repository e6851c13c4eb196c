"""What a service manager is told, and what it is asked for: systemd, or one that speaks like it."""
