"""Figures for a paper, in the arrangement of the drop test's own. Needs matplotlib, the extra `figures`."""
