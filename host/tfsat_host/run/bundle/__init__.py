"""All of one drop in one file, and what it takes to compute it again from raw."""
