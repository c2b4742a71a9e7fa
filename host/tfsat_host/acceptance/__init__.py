"""Acceptance of a robot with its boards: every wire, sensor, switch and servo shown to be where it belongs.

Nothing of it is a calibration: it names what is wired wrongly, before calibrations and drops rest on it.
"""
