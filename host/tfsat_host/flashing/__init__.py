"""Putting an image on the sequencer: reading it, waking the bootloader, writing, and asking the board what it runs."""
