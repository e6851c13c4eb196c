"""A study: a grid of configurations × seeds, each learned and measured in a worker process.

definition axes settings targets shipped    the TOML file: its cells, and what is expected of them
unit measuring worker                       one run of a study, as a pure function; a process of it
results                                     the file that keeps the units' results
study                                       a study from its file to its page
summary page figure                         what it shows: interquartile means with intervals
"""
