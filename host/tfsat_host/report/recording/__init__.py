"""The evaluated drop for Foxglove, PlotJuggler and Rerun: the recording and what it was found to say, as MCAP."""
