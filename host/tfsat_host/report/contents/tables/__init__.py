"""The tables of one drop."""
