"""What a user does first, with the wheel and what it depends on: ``first_steps.py README.md``.

Every snippet of the page runs, with short trainings, except for those that need other packages
or their environments.
"""

import functools
import multiprocessing
import re
import subprocess
import sys
from pathlib import Path

import gymnasium
import rher

#: Steps of each training.
SHORT = 500


def main() -> None:
    if sys.version_info < (3, 14):
        # Later versions warn of it where there are threads, as there are here.
        _travels("fork")
    for method in ("spawn", "forkserver"):
        _travels(method)
    _snippets(Path(sys.argv[1]).read_text())


def _travels(method: str) -> None:
    """Environments, states and policies go to another process and back."""
    env = gymnasium.make("rher/Push-v0")
    env.reset(seed=0)
    policy = rher.Policy.pretrained("push")
    with multiprocessing.get_context(method).Pool(1) as pool:
        there = pool.apply(_acts, (env, policy))
    assert there == _acts(env, policy), f"pickled by {method}, it acts otherwise"


def _acts(env: gymnasium.Env, policy: rher.Policy) -> list[float]:
    seen, _ = env.reset(seed=1)
    for _ in range(20):
        seen, *_ = env.step(policy(seen))
    return seen["observation"].tolist()


def _snippets(page: str) -> None:
    short = functools.partial(rher.train, env_steps=SHORT)
    # The page compares with this run, and trains this plan.
    short("push", seed=2)
    sweep = ["sweep", "push", "--seeds", "1-2", "--plan", "plan.jsonl"]
    subprocess.run([Path(sys.executable).with_name("rher"), *sweep], check=True)
    rher.train = short
    names: dict[str, object] = {}
    ran = 0
    for snippet in re.findall(r"^```python\n(.*?)^```$", page, re.MULTILINE | re.DOTALL):
        if re.search("fetch|panda", snippet, re.IGNORECASE):
            continue
        try:
            exec(compile(snippet, "README.md", "exec"), names)
            ran += 1
        except ImportError as error:
            # Either says how to get what is missing.
            assert "pip install" in str(error) or error.name == "stable_baselines3", error
    assert ran >= 4, f"only {ran} snippets ran"


if __name__ == "__main__":
    main()
