#!/usr/bin/env bash
# LeRobot 0.6.1, `eval_policy`, which is what `lerobot-eval` reports: an episode that ends before the
# others of its batch is given one step too many, the first one of the next episode, with its reward
# and its success. And an episode counts as a success if any step was successful, also where its last
# step was not, although the documentation of `rollout` says that success can only be true at the end:
# environments such as Gymnasium-Robotics' say at every step whether the goal is reached just now.
#
# A good guess: an episode of three steps of reward 1 has a return of 3, and one that ends away from
# its goal is a failure.
#
# Seen (it needs Python 3.12):
#   3 steps of reward 1, successful in the second alone: return 4.0, success True
#   9 steps of reward 1, never successful: return 9.0, success False
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3.12 -m venv "$folder/venv"
install=("$folder/venv/bin/pip" install --quiet --disable-pip-version-check)
"${install[@]}" av==15.1.0 datasets==4.8.5 draccus==0.11.6 einops==0.8.2 gymnasium==1.4.0 \
  huggingface-hub==1.33.0 opencv-python-headless==4.13.0.92 pillow==12.0.0 safetensors==0.8.0 \
  termcolor==3.3.0 torch==2.15.0
"${install[@]}" --no-deps lerobot==0.6.1 torchvision==0.29.2
"$folder/venv/bin/python" -W ignore - 2> "$folder/progress" <<'EOF' || { cat "$folder/progress"; exit 1; }
import gymnasium
import numpy as np
import torch
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from lerobot.policies import PreTrainedPolicy
from lerobot.policies.act.configuration_act import ACTConfig
from lerobot.processor import PolicyProcessorPipeline, make_policy_processor_pipelines
from lerobot.scripts.lerobot_eval import eval_policy


class Timed(gymnasium.Env):
    """Rewards every step, is cut off after so many, and is successful in some of them."""

    observation_space = gymnasium.spaces.Dict({"agent_pos": gymnasium.spaces.Box(-1.0, 1.0, (1,))})
    action_space = gymnasium.spaces.Box(-1.0, 1.0, (1,))
    _max_episode_steps = 9
    task_description = ""

    def __init__(self, steps, successful):
        self.steps, self.successful = steps, successful

    def seen(self):
        return {"agent_pos": np.zeros(1, np.float32)}

    def reset(self, *, seed=None, options=None):
        self.step_count = 0
        return self.seen(), {}

    def step(self, action):
        self.step_count += 1
        info = {"is_success": self.step_count in self.successful}
        return self.seen(), 1.0, False, self.step_count == self.steps, info


class Still(PreTrainedPolicy):
    config_class = ACTConfig
    name = "still"

    def reset(self):
        pass

    def get_optim_params(self):
        return {}

    def forward(self, batch):
        raise NotImplementedError

    def predict_action_chunk(self, batch):
        raise NotImplementedError

    def select_action(self, batch):
        return torch.zeros(2, 1)


envs = [lambda: Timed(3, {2}), lambda: Timed(9, set())]
# As LeRobot makes its own.
envs = SyncVectorEnv(envs, autoreset_mode=AutoresetMode.SAME_STEP)
policy = Still(ACTConfig(device="cpu", push_to_hub=False))
nothing = PolicyProcessorPipeline(steps=[])
before, after = make_policy_processor_pipelines([], [])
short, long = eval_policy(envs, policy, nothing, nothing, before, after, n_episodes=2)["per_episode"]
for what, episode in [
    ("3 steps of reward 1, successful in the second alone", short),
    ("9 steps of reward 1, never successful", long),
]:
    print(f"{what}: return {episode['sum_reward']}, success {episode['success']}")
assert (short["sum_reward"], short["success"]) == (4.0, True), "LeRobot behaves differently now"
assert (long["sum_reward"], long["success"]) == (9.0, False), "LeRobot behaves differently now"
EOF
