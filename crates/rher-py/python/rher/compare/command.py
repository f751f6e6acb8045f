"""The command ``python -m rher.compare``."""

import argparse
import json
import sys
import time
import warnings
from pathlib import Path

import rher.compare
from rher.compare import blocks, foreign, learning, machine, relabeling, single, transfer, vector
from rher.compare.part import Measured, Part

PARTS: dict[str, Part] = {
    "single": single.PART,
    "vector": vector.PART,
    "relabeling": relabeling.PART,
    "transfer": transfer.PART,
    "blocks": blocks.PART,
    "learning": learning.PART,
    "foreign": foreign.PART,
}


def main(arguments: list[str] | None = None) -> None:
    """What the command line asks for."""
    args = _parser().parse_args(arguments)
    warnings.filterwarnings("ignore", module="gymnasium")
    args.out.mkdir(parents=True, exist_ok=True)
    results: Measured = {"machine": machine.machine(), "quick": args.quick}
    for part in args.parts:
        print(f"{part} ...", file=sys.stderr, flush=True)
        started = time.perf_counter()
        results[part] = PARTS[part].measure(args)
        results[part]["seconds"] = round(time.perf_counter() - started, 1)
        # A later part may take hours, or fail.
        _write(args.out / "compare.json", json.dumps(results, indent=2) + "\n")
        _write(args.out / "compare.md", report(results))
    print(report(results))


def report(results: Measured) -> str:
    """The tables, in Markdown."""
    lines = ["# rher and its neighbors", "", *machine.lines(results["machine"])]
    if results["quick"]:
        lines += ["", "Measured for moments only (`--quick`): these are no results."]
    for name, part in PARTS.items():
        if name in results:
            lines += ["", *part.lines(results[name])]
    return "\n".join(lines) + "\n"


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m rher.compare", description=rher.compare.__doc__
    )
    parser.add_argument("--out", type=Path, default=Path("compare"), help="folder of the results")
    parser.add_argument(
        "--parts", nargs="+", choices=PARTS, default=list(PARTS), metavar="PART",
        help=f"what to compare: {', '.join(PARTS)} (default: all)",
    )
    parser.add_argument("--quick", action="store_true", help="measure for moments only")
    for part in PARTS.values():
        part.add_arguments(parser)
    return parser


def _write(path: Path, text: str) -> None:
    """Writes a file whole or not at all."""
    new = path.with_name(path.name + ".new")
    new.write_text(text)
    new.replace(path)
