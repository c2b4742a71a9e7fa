"""What a live view shows, worked out from what the boards say: no ports, no terminal, no clock of its own."""
