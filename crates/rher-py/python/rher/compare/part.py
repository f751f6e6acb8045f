"""What a part of the comparison is."""

from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

#: What a part has found, as JSON has it.
Measured = dict[str, Any]


def no_arguments(parser: ArgumentParser) -> None:
    """For parts without arguments."""


@dataclass(frozen=True)
class Part:
    """One comparison: its arguments, its measurement, and its table."""

    #: Measures; what it returns is the raw data.
    measure: Callable[[Namespace], Measured]
    #: The lines of its table, in Markdown, made of the raw data alone.
    lines: Callable[[Measured], list[str]]
    #: Adds its arguments to those of the command.
    add_arguments: Callable[[ArgumentParser], None] = no_arguments


def ratios(rows: list[tuple[str, float, float]]) -> list[str]:
    """A table of rates: what it is, ours, theirs, and how many times as much ours is."""
    lines = ["| what | ours | theirs | ratio |", "|---|---|---|---|"]
    for what, ours, theirs in rows:
        lines.append(f"| {what} | {ours:,.0f} | {theirs:,.0f} | {ours / theirs:.1f} × |")
    return lines
