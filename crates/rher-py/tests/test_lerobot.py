"""Policies in LeRobot's own evaluation."""

import copy
import json
import subprocess
import sys
from pathlib import Path

import gymnasium
import numpy as np
import pytest

import rher

torch = pytest.importorskip("torch")
pytest.importorskip("lerobot_policy_rher.configuration_rher", reason="lerobot_policy_rher is not installed")
from lerobot.envs import make_env, make_env_config  # noqa: E402
from lerobot.policies import make_policy, make_pre_post_processors  # noqa: E402
from lerobot.configs import PreTrainedConfig  # noqa: E402
from lerobot.processor import PolicyProcessorPipeline  # noqa: E402
from lerobot.scripts.lerobot_eval import eval_policy  # noqa: E402
from lerobot.utils.import_utils import register_third_party_plugins  # noqa: E402
from lerobot_policy_rher.__main__ import write  # noqa: E402
from lerobot_policy_rher.modeling_rher import RherPolicy  # noqa: E402

register_third_party_plugins()

FIRST_SEED = 1000


@pytest.fixture(params=["push", "dpush"])
def written(request, tmp_path):
    """A task, its policy, and the folder that LeRobot loads."""
    policy = rher.Policy.pretrained(request.param)
    write(policy, tmp_path / "policy")
    name = next(name for name, task in rher.IDS.items() if task == request.param)
    return name, policy, tmp_path / "policy"


def loaded(folder, env_config):
    """What ``lerobot-eval`` makes of ``--policy.path``."""
    config = PreTrainedConfig.from_pretrained(folder)
    config.pretrained_path = folder
    return make_policy(config, env_cfg=env_config), make_pre_post_processors(config, folder)


def play(name, policy, seed):
    """Rewards of an episode, and whether it ended in success."""
    env = gymnasium.make(name)
    seen, _ = env.reset(seed=seed)
    begun, rewards, truncated = policy.begin(seen), [], False
    while not truncated:
        seen, reward, _, truncated, info = env.step(begun(seen))
        rewards.append(reward)
    return rewards, bool(info["is_success"])


def test_lerobot_finds_what_we_find(written):
    name, policy, folder = written
    env_config = make_env_config("rher", task=name)
    envs = make_env(env_config, n_envs=3)["rher"][0]
    theirs, (before, after) = loaded(folder, env_config)
    nothing = PolicyProcessorPipeline(steps=[])
    # One more than can be evaluated together, so that a second round begins.
    found = eval_policy(
        envs, theirs, nothing, nothing, before, after, n_episodes=4, start_seed=FIRST_SEED
    )
    for index, episode in enumerate(found["per_episode"]):
        rewards, success = play(name, policy, FIRST_SEED + index)
        assert episode["success"] == success
        assert episode["sum_reward"] == pytest.approx(sum(rewards))
    envs.close()


def test_the_program_of_lerobot_loads_a_policy_by_its_folder(tmp_path):
    def run(*command):
        done = subprocess.run([*command], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    assert run(sys.executable, "-m", "lerobot_policy_rher", "reach", "-o", "reach").strip() == "reach"
    run(
        Path(sys.executable).with_name("lerobot-eval"), "--policy.path=reach", "--env.type=rher",
        "--env.task=rher/Reach-v0", "--eval.n_episodes=2", "--eval.batch_size=2", "--output_dir=out",
    )  # fmt: skip
    found = json.loads((tmp_path / "out" / "eval_info.json").read_text())
    assert found["overall"]["pc_success"] == 100.0
    assert all(Path(tmp_path, film).stat().st_size for film in found["overall"]["video_paths"])


def test_a_policy_is_saved_and_copied_and_acts_the_same(tmp_path):
    policy = rher.Policy.pretrained("push")
    write(policy, tmp_path / "first")
    first = RherPolicy.from_pretrained(tmp_path / "first")
    first.save_pretrained(tmp_path / "second")
    seen, _ = gymnasium.make("rher/Push-v0").reset(seed=0)
    batch = {f"observation.{key}": torch.tensor(value)[None] for key, value in seen.items()}
    expected = policy(seen)
    for ours in [first, RherPolicy.from_pretrained(tmp_path / "second"), copy.deepcopy(first)]:
        ours.reset()
        assert np.array_equal(ours.select_action(batch).numpy(), expected[None])
        assert ours.predict_action_chunk(batch).shape == (1, 1, 4)


def test_success_is_that_of_the_end():
    envs = make_env(make_env_config("rher", task="rher/Push-v0"), n_envs=1)["rher"][0]
    envs.reset(seed=[0], options={"lerobot_new_rollout": True})
    for _ in range(49):
        assert "is_success" not in envs.step(envs.action_space.sample() * 0)[-1]
    assert "is_success" in envs.step(envs.action_space.sample() * 0)[-1]["final_info"]
    envs.close()


def test_wrong_inputs_are_named(tmp_path):
    write(rher.Policy.pretrained("push"), tmp_path)
    policy = RherPolicy.from_pretrained(tmp_path)
    with pytest.raises(ValueError, match="the batch has no observation.achieved_goal"):
        policy.select_action({"observation.observation": torch.zeros(1, 25)})
    seen, _ = gymnasium.make("rher/Push-v0").reset(seed=0)
    batch = {f"observation.{key}": torch.tensor(value)[None] for key, value in seen.items()}
    batch["observation.observation"][0, 3] = torch.nan
    with pytest.raises(rher.InputError, match="finite"):
        policy.select_action(batch)
    with pytest.raises(NotImplementedError, match="not LeRobot"):
        policy.forward(batch)
    with pytest.raises(ValueError, match="has no network"):
        RherPolicy(policy.config).select_action(batch)
    with pytest.raises(ValueError, match="expected a dictionary"):
        make_env_config("rher", task="CartPole-v1", package="gymnasium")
