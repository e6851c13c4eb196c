"""What `reflexarc run` is made of: the loop with all that it is connected to, and its flags."""
