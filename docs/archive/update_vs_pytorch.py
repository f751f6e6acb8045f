"""One TD3 update, ours against PyTorch, in alternating rounds on one thread.

    pip install torch
    cargo build --release
    python docs/archive/update_vs_pytorch.py target/release/rher

Both do the same arithmetic: twin critics and an actor of 3 x 256 rectified units, 31 inputs,
4 actions, float32, Adam, target smoothing, an actor step and moved targets every second update.
PyTorch is used as its documentation has it: eager mode, Adam with foreach, one thread.
"""

import argparse
import json
import os
import statistics
import subprocess
import time

os.environ["OMP_NUM_THREADS"] = "1"

import torch
from torch import nn

INPUTS, ACTIONS, HIDDEN = 31, 4, (256, 256, 256)
DISCOUNT, RATE, TARGET_RATE, DELAY = 0.95, 1e-3, 0.01, 2
NOISE, NOISE_CLIP, ACTION_L2 = 0.2, 0.5, 1.0
WARM_UP, MEASURED = 0.5, 1.5  # seconds


def network(inputs, outputs):
    widths = (inputs, *HIDDEN)
    layers = []
    for before, after in zip(widths, widths[1:]):
        layers += [nn.Linear(before, after), nn.ReLU()]
    return nn.Sequential(*layers, nn.Linear(widths[-1], outputs))


class Learner:
    def __init__(self):
        self.actor = network(INPUTS, ACTIONS)
        self.critics = nn.ModuleList(network(INPUTS + ACTIONS, 1) for _ in range(2))
        self.actor_target = network(INPUTS, ACTIONS)
        self.critics_target = nn.ModuleList(network(INPUTS + ACTIONS, 1) for _ in range(2))
        self.actor_target.load_state_dict(self.actor.state_dict())
        self.critics_target.load_state_dict(self.critics.state_dict())
        self.actor_adam = torch.optim.Adam(self.actor.parameters(), lr=RATE, foreach=True)
        self.critic_adam = torch.optim.Adam(self.critics.parameters(), lr=RATE, foreach=True)
        self.online = [*self.actor.parameters(), *self.critics.parameters()]
        self.target = [*self.actor_target.parameters(), *self.critics_target.parameters()]
        self.updates = 0

    def update(self, states, actions, rewards, next_states):
        self.updates += 1
        with torch.no_grad():
            noise = (torch.randn_like(actions) * NOISE).clamp(-NOISE_CLIP, NOISE_CLIP)
            said = (torch.tanh(self.actor_target(next_states)) + noise).clamp(-1, 1)
            pair = torch.cat((next_states, said), 1)
            value = torch.min(*(critic(pair) for critic in self.critics_target))
            returns = (rewards + DISCOUNT * value).clamp(-1 / (1 - DISCOUNT), 0)
        pair = torch.cat((states, actions), 1)
        loss = sum(nn.functional.mse_loss(critic(pair), returns) for critic in self.critics)
        self.critic_adam.zero_grad()
        loss.backward()
        self.critic_adam.step()
        if self.updates % DELAY:
            return
        said = torch.tanh(self.actor(states))
        self.critics.requires_grad_(False)
        loss = -self.critics[0](torch.cat((states, said), 1)).mean()
        loss = loss + ACTION_L2 * said.square().mean()
        self.actor_adam.zero_grad()
        loss.backward()
        self.actor_adam.step()
        self.critics.requires_grad_(True)
        with torch.no_grad():
            torch._foreach_lerp_(self.target, self.online, TARGET_RATE)


def pytorch(learner, batch):
    """CPU milliseconds of one update."""
    rows = (
        torch.randn(batch, INPUTS),
        torch.rand(batch, ACTIONS) * 2 - 1,
        -torch.randint(0, 2, (batch, 1)).float(),
        torch.randn(batch, INPUTS),
    )
    for seconds in (WARM_UP, MEASURED):
        updates, wall, cpu = 0, time.perf_counter(), time.process_time()
        while time.perf_counter() - wall < seconds:
            for _ in range(DELAY):
                learner.update(*rows)
            updates += DELAY
    return 1e3 * (time.process_time() - cpu) / updates


def ours(rher, batch):
    """CPU milliseconds of one update."""
    command = f"{rher} bench update --engine fused --inputs {INPUTS} --threads 1 --json"
    command = [*command.split(), "--batch", str(batch)]
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return json.loads(printed)[0]["cpu_ms_per_update"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("rher", help="the program, built with `cargo build --release`")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--batch", type=int, nargs="+", default=[256, 2048])
    args = parser.parse_args()
    torch.set_num_threads(1)
    print(f"PyTorch {torch.__version__}, CPU ms per update, medians of {args.rounds} rounds")
    for batch in args.batch:
        learner = Learner()
        rounds = [(ours(args.rher, batch), pytorch(learner, batch)) for _ in range(args.rounds)]
        ratios = [mine / theirs for mine, theirs in rounds]
        mine, theirs = (statistics.median(side) for side in zip(*rounds))
        print(
            f"batch {batch:>5}: ours {mine:.2f}, PyTorch {theirs:.2f}, "
            f"ratio {statistics.median(ratios):.2f} ({min(ratios):.2f} to {max(ratios):.2f})"
        )


if __name__ == "__main__":
    main()
