"""The logger's recordings: blocks on a card become columns in SI units, with a verdict."""

from .assembly import SetAside
from .droplog import DropLog
from .errors import LogError, SessionError
from .events import DropEvent
from .gaps import Gap
from .load import load

__all__ = ["DropEvent", "DropLog", "Gap", "LogError", "SessionError", "SetAside", "load"]
