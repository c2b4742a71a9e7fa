"""What an evaluation found, declared once for terminal, JSON, page and figures."""
