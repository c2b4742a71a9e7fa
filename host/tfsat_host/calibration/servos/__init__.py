"""Where a servo comes to rest for a pulse, and what that makes of a stroke."""
