"""Trained policies as ONNX models, for robots and programs without this package.

>>> import rher.onnx
>>> rher.onnx.export(run, "policy.onnx")

``rher export RUN --format onnx --out policy.onnx`` does the same, and so does ``python -m rher.onnx RUN -o
policy.onnx``. What runs the model needs only an ONNX runtime.
"""

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from rher import _rher
from rher._arguments import path as as_path
from rher.errors import RherError
from rher.run import Run

__all__ = ["export"]

#: Name of the policy in a run folder.
POLICY_FILE = "policy.safetensors"


def export(
    policy: _rher.Policy | Run | str | os.PathLike[str], out: str | os.PathLike[str]
) -> Path:
    """Writes a policy as an ONNX model, and beside it what its numbers are.

    The model has everything that the policy needs to act: its inputs are the parts of the dictionary
    that the environment returns, as single-precision numbers in rows, and its output is ``action``.
    Where the policy has learned in which order the objects are placed best, it chooses as
    :meth:`rher.Policy.begin` does; two more inputs, ``first_observation`` and
    ``first_achieved_goal``, are then those that the episode began with. A row with a number that is
    not finite gets an action of NaN.

    The file beside it, ``policy.json`` for ``policy.onnx``, has names, shapes, units, the frame, the
    rate, limits, the task and hashes; ``docs/onnx.md`` explains it.

    :param policy: a policy, a run, or the path of a run's folder or of a policy file.
    :param out: the model, whose name ends in ``.onnx``.
    :return: the model.
    :raise PolicyError: if the file holds no policy, or one that cannot be exported.
    :raise FileError: if a file cannot be read or written.
    """
    model = Path(as_path("out", out))
    _rher.export_onnx(_policy(policy), model)
    return model


def _policy(policy: _rher.Policy | Run | str | os.PathLike[str]) -> _rher.Policy | Path:
    """The policy itself, or the file of one."""
    if isinstance(policy, _rher.Policy):
        return policy
    path = policy.path if isinstance(policy, Run) else Path(as_path("policy", policy))
    return path / POLICY_FILE if path.is_dir() else path


def main(arguments: Sequence[str] | None = None) -> int:
    """The command ``python -m rher.onnx``; its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m rher.onnx",
        description="Write a trained policy as an ONNX model, and beside it what its numbers are.",
    )
    parser.add_argument(
        "run",
        help="folder of a run, a policy file, or the name of a task, whose policy ships with rher",
    )
    parser.add_argument(
        "-o", "--out", default="policy.onnx", help="the model [default: policy.onnx]"
    )
    asked = parser.parse_args(arguments)
    try:
        is_shipped = asked.run in _rher.tasks() and not os.path.exists(asked.run)
        policy = _rher.Policy.pretrained(asked.run) if is_shipped else asked.run
        model = export(policy, asked.out)
    except RherError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    print(f"{model} and {model.with_suffix('.json')}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
