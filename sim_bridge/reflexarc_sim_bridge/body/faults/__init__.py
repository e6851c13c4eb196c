"""Sensor faults on purpose: scripts of delay, loss and damage, and the stream they act on."""
