"""What a track says of who drove it: pure functions, each with its formula."""
