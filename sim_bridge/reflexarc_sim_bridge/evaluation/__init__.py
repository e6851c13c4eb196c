"""Measuring policies and worlds: contacts per 100 m, confidence intervals, fairness of a world."""
