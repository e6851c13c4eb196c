"""A candidate policy judged on logs that another one drove; many logs at once.

judge_logs             many logs, shared among processes
judge_log              one log, one pass
judgement              what is found on a log, as data
judgement_report       on all logs: as data, as text, as a comment on a change
flip_limits            how much a candidate may differ
replay_logs            many logs replayed by this software
"""
