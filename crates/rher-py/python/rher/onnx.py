"""Trained policies as ONNX models, for robots and programs without this package.

>>> import rher.onnx
>>> rher.onnx.export(run, "policy.onnx")

``python -m rher.onnx RUN -o policy.onnx`` does the same. It needs the package ``onnx``; what runs the
model needs only an ONNX runtime.
"""

import argparse
import hashlib
import json
import os
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rher import _rher
from rher._arguments import path as as_path
from rher._policy_file import PolicyFile
from rher._policy_file import read as read_policy
from rher.errors import FileError, InputError, MissingError, RherError
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
    :raise MissingError: without the package ``onnx``.
    """
    try:
        from rher import _onnx_graph
    except ImportError as error:
        raise MissingError(
            "onnx is not installed: `pip install 'rher[onnx]'` installs it"
        ) from error
    model_path = Path(as_path("out", out))
    if model_path.suffix != ".onnx":
        raise InputError(f"out is `{model_path}`, expected a name that ends in .onnx")
    exported = _read(policy)
    metadata = {"task": exported.task, "policy_sha256": exported.sha256}
    model = _onnx_graph.model_of(exported, _rher.__version__, metadata).SerializeToString()
    about = {
        "file": model_path.name,
        "sha256": hashlib.sha256(model).hexdigest(),
        "opset": _onnx_graph.OPSET,
    }
    contract = _contract(exported, about)
    _replace(model_path, model)
    _replace(model_path.with_suffix(".json"), f"{json.dumps(contract, indent=2)}\n".encode())
    return model_path


def _read(policy: _rher.Policy | Run | str | os.PathLike[str]) -> PolicyFile:
    if isinstance(policy, _rher.Policy):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / POLICY_FILE
            policy.save(file)
            return read_policy(file)
    path = policy.path if isinstance(policy, Run) else Path(as_path("policy", policy))
    return read_policy(path / POLICY_FILE if path.is_dir() else path)


def _contract(policy: PolicyFile, model: dict[str, Any]) -> dict[str, Any]:
    """What has to be known to run the model."""
    control, objects = policy.control, policy.names.get("objects", [])
    whole = policy.names.get("observation", []), control.get("observation_units", [])
    goals = (
        [f"{name}.position.{axis}" for name in objects for axis in "xyz"],
        ["m"] * 3 * policy.objects,
    )
    meanings = {
        "observation": (*whole, "`observation` of the environment"),
        "achieved_goal": (*goals, "where the objects are"),
        "desired_goal": (*goals, "where the objects should be"),
        "first_observation": (*whole, "`observation` when the episode began"),
        "first_achieved_goal": (*goals, "where the objects were when the episode began"),
    }
    if policy.is_reach:
        meanings["achieved_goal"] = (*goals, "not used: what is to be reached stays where it is")

    def row(name: str, width: int) -> dict[str, Any]:
        names, units, meaning = meanings[name]
        return {
            "name": name,
            "meaning": meaning,
            "dtype": "float32",
            "shape": ["batch", width],
            "names": names,
            "units": units,
        }

    return {
        "contract": 1,
        "task": policy.task,
        "settings": _settings(policy.variant),
        "objects": objects,
        "rate_hz": control.get("rate_hz"),
        "frame": control.get("frame", ""),
        "inputs": [row(name, width) for name, width in policy.inputs.items()],
        "outputs": [
            {
                "name": "action",
                "meaning": "what to do until the next one; NaN where an input is not finite",
                "dtype": "float32",
                "shape": ["batch", policy.action],
                "names": policy.names.get("action", []),
                "units": control.get("action_units", []),
                "limits": [-1.0, 1.0],
            }
        ],
        "model": model,
        "policy": {"sha256": policy.sha256, "run": policy.run},
        "rher": _rher.__version__,
    }


def _settings(variant: str) -> Any:
    """Settings of the environment as a table, or in its own words."""
    try:
        return json.loads(variant)
    except json.JSONDecodeError:
        return variant


def _replace(path: Path, content: bytes) -> None:
    """Writes a file that is complete or absent."""
    beside = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        try:
            beside.write_bytes(content)
            beside.replace(path)
        finally:
            beside.unlink(missing_ok=True)
    except OSError as error:
        raise FileError(f"cannot write `{path}`: {error}") from error


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
