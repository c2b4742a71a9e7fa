"""What a command shows on a terminal: its streams, and declared tables and quantities (`tfsat_host.quantity`)."""
