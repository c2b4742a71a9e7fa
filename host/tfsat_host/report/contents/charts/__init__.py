"""The charts of one drop: the paper's figures, and what they rest on."""
