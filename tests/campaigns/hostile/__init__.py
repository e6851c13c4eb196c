"""Files that were made to harm: each command gives one line, in time, in bounded memory."""
