"""A candidate policy judged on logs that another one drove; many logs at once; a log as a test.

judge_logs             many logs, shared among processes
judge_log              one log, one pass
judgement              what is found, as data
flip_limits            how much a candidate may differ
judgement_text         as text; judgement_markdown: as a comment on a change
failure_text           why a log's test failed, in words
"""
