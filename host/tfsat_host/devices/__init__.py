"""The boards as the host sees them: finding a port, opening it, speaking to what is there."""
