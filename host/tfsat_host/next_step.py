"""What to type next: advice to people, in which commands stay values until they are shown.

Who raises an error knows the command that mends it; which port, certificate or image was named, only the
command line knows. It adds them where it shows the advice (`cli/next_steps.py`).
"""

from __future__ import annotations

import shlex
from dataclasses import dataclass

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Self


@dataclass(frozen=True, slots=True)
class NextStep:
    """A command of `tfsat-host` to type.

    Attributes:
        command: The command and its action: `calibrate bias`.
        arguments: As the program gets them; they are quoted for a shell where that needs it.
    """

    command: str
    arguments: tuple[str, ...] = ()

    def with_arguments(self, *arguments: str) -> NextStep:
        """Return the same command with more arguments."""
        return NextStep(self.command, (*self.arguments, *arguments))

    def with_recording(self, recording: str) -> NextStep:
        """Return `decode` with a recording unless it names a file, and any other command as it is."""
        # A recording goes before options: `decode --format parquet` names none.
        if self.command != "decode" or not all(word.startswith("--") for word in self.arguments[:1]):
            return self
        return NextStep(self.command, (recording, *self.arguments))

    def __str__(self) -> str:
        """Return what to type."""
        return " ".join(("tfsat-host", self.command, *map(shlex.quote, self.arguments)))


def install_extra(name: str) -> str:
    """Return the command that installs an extra wherever tfsat-host itself is installed, from a checkout or a wheel."""
    return f"python -m pip install 'tfsat-host[{name}]'"


class Advice(str):
    """A text for people, made of words and commands; as a string, the commands are as their author wrote them.

    Put into another text it is a mere string; `Advice(advice, "more words")` keeps its commands.
    """

    __slots__ = ("parts",)
    parts: tuple[str | NextStep, ...]

    def __new__(cls, *parts: str | NextStep) -> Self:
        """Join words and commands, as they come."""
        flat: list[str | NextStep] = []
        for part in parts:
            flat += part.parts if isinstance(part, Advice) else (part,)
        advice = super().__new__(cls, "".join(map(str, flat)))
        advice.parts = tuple(flat)
        return advice

    def __str__(self) -> str:
        """Return the text with its commands: `str` of an advice is an advice."""
        return self

    def __reduce__(self) -> tuple[type[Self], tuple[str | NextStep, ...]]:
        """Keep the commands on the way to another process."""
        return type(self), self.parts

    def with_commands(self, complete: Callable[[NextStep], NextStep]) -> Advice:
        """Return the same advice, its commands completed."""
        return Advice(*(complete(part) if isinstance(part, NextStep) else part for part in self.parts))


def name_recording(text: str, recording: str) -> str:
    """Return a text whose `decode` commands name the recording: for readers who do not know of which it speaks."""
    return (
        text.with_commands(lambda step: step.with_recording(recording)) if isinstance(text, Advice) else text
    )
