"""Plain rules that everyone knows: what a learned policy has to beat."""
