"""The checks, by what they look at: each takes the evidence and gives one line."""
