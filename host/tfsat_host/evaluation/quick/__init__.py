"""The first look after a drop, without a calibration."""
