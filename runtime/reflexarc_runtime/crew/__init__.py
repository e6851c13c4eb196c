"""Worker processes that do tasks, replaced when they die, and the file that keeps what they found.

crew worker_process    the side that gives tasks
worker                 the side that does them
lines_file             what is kept, line by line
"""
