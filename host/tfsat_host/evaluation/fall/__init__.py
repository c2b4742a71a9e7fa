"""Rest, release, weightlessness and landing, as the accelerometers felt them."""
