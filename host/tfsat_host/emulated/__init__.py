"""The emulated robot: the real firmware, the physics and a card, in virtual time, in this process."""
