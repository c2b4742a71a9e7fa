"""What a campaign ends with when something did not hold."""


class Broken(Exception):
    """A promise that the logger or the decoder did not keep."""
