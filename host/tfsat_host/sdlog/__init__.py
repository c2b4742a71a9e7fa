"""The logger's recordings: blocks on a card become columns in SI units, with a verdict."""

from .droplog import DropLog
from .events import DropEvent
from .ledger import Gap
from .load import load
from .log_errors import LogError, SessionError
from .recordings import SetAside

__all__ = ["DropEvent", "DropLog", "Gap", "LogError", "SessionError", "SetAside", "load"]
