"""Whether fingers close while the hand presses on the table: in ours they do, in MuJoCo hardly.

Prints how far a finger is open, in millimeters, step by step while it is to close and the hand to go
down as fast as the action says. Then, for each policy that is named (a task's, or a file), in how many
episodes of `stack` or `tstack` in MuJoCo that held fingers open for 5 steps or more.

    python pressed_fingers.py stack tstack runs/robust/policy.safetensors

Needs rher with the extra `compare`.
"""

import sys

import numpy as np
import rher
from rher.compare import block_scene

EPISODES = 200


def closing(env, opening, down):
    """How far a finger is open while it closes, in millimeters."""
    # Neither block is below the hand.
    env.reset(seed=0, options={"layout": [1.2, 0.62, 0.425, 1.2, 0.9, 0.425]})
    lowered = 6 * [[0, 0, -1, 1]] + 2 * [[0, 0, -0.1, 1]]
    seen = [env.step(np.array(action, np.float32))[0] for action in lowered][-1:]
    seen += [env.step(np.array([0, 0, down, -1], np.float32))[0] for _ in range(6)]
    return [round(1000 * float(one["observation"][opening])) for one in seen]


def held_open(policy):
    """Solved and failed episodes, with and without fingers that were held open."""
    env, names = block_scene.make(policy.task), block_scene.names(policy.task)
    first, height = names.index("finger1.opening"), names.index("gripper.position.z")
    counts = {(solved, held): 0 for solved in (True, False) for held in (True, False)}
    for seed in range(EPISODES):
        seen, info = env.reset(seed=seed)
        act, done, steps = policy.begin(seen), False, 0
        while not done:
            action = act(seen)
            before = seen["observation"][first : first + 2]
            seen, _, _, done, info = env.step(action)
            after = seen["observation"][first : first + 2]
            presses = action[2] < 0 and seen["observation"][height] < 0.4205
            steps += bool(
                presses and action[3] < -0.3 and after.min() > 0.03 and (before - after).max() < 0.003
            )
        counts[bool(info["is_success"]), steps >= 5] += 1
    return counts


names = block_scene.names("stack")
for down in (0.0, -0.1, -0.4, -1.0):
    for where, env in (("ours", rher.TaskEnv("stack")), ("MuJoCo", block_scene.make("stack"))):
        print(f"{down:4} {where:6}", closing(env, names.index("finger1.opening"), down))
for name in sys.argv[1:]:
    policy = rher.Policy.pretrained(name) if name in block_scene.TASKS else rher.Policy.load(name)
    for (solved, held), count in held_open(policy).items():
        print(name, "solved" if solved else "failed", "held open" if held else "not held", count)
