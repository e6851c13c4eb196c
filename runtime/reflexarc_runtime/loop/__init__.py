"""The sense–act loop: when a tick begins, what it receives, how punctual it was, who is waiting."""
