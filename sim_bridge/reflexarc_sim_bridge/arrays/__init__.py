"""Memory of a simulation: the named arrays that compiled code reads and writes, and their sizes."""
