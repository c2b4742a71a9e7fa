"""The release velocity from the tracks of two laser spots."""
