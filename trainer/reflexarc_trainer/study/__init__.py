"""A grid of configurations × seeds, learned and measured by processes of their own.

A file a concept:

    study_file axes settings targets shipped    what a study asks: a TOML file, its cells
    unit measuring                 one run of it: a pure function of what it is given
    worker worker_process crew     processes that do units, replaced when they die
    results                        where what they find is kept
    study_run                      a study from its file to its page
    summary page figure            what it says: interquartile means with intervals
"""
