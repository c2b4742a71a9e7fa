"""A folder of numbered drops with an index that people can read."""
