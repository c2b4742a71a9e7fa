"""Plans on orbit: chains of primitives to a target attitude, flown and planned again."""
