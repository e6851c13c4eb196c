"""The page of a suite's results: one HTML file that shows all of them and needs nothing else."""
