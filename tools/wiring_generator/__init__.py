"""What tools/generate_wiring.py is made of: docs/wiring.toml in, the drawing and the page out."""
