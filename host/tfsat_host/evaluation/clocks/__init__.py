"""The clocks of sequencer and video against the logger's."""
