"""``python -m lerobot_policy_rher RUN -o FOLDER`` writes a policy as LeRobot loads it."""

import argparse
import os
import sys
from pathlib import Path

import rher
from lerobot_policy_rher.configuration_rher import RherConfig, features_of
from lerobot_policy_rher.modeling_rher import RherPolicy
from lerobot_policy_rher.processor_rher import make_rher_pre_post_processors

#: Name of the policy in a run folder.
POLICY_FILE = "policy.safetensors"


def write(policy: rher.Policy, folder: Path) -> None:
    """Writes a folder for LeRobot's ``--policy.path``."""
    widths = policy.observation_width, 3 * policy.objects, policy.action_width
    inputs, outputs = features_of(*widths)
    config = RherConfig(input_features=inputs, output_features=outputs, push_to_hub=False)
    RherPolicy(config, policy=policy).save_pretrained(folder)
    for pipeline in make_rher_pre_post_processors(config):
        pipeline.save_pretrained(folder)


def main() -> int:
    """The command; its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m lerobot_policy_rher",
        description="Write a trained policy as a folder for LeRobot's --policy.path.",
    )
    parser.add_argument(
        "run",
        help="folder of a run, a policy file, or the name of a task, whose policy ships with rher",
    )
    parser.add_argument("-o", "--out", type=Path, default=Path("policy"), help="the folder")
    asked = parser.parse_args()
    try:
        path = Path(asked.run)
        if asked.run in rher.tasks() and not os.path.exists(path):
            policy = rher.Policy.pretrained(asked.run)
        else:
            policy = rher.Policy.load(path / POLICY_FILE if path.is_dir() else path)
        write(policy, asked.out)
    except rher.RherError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    print(asked.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
