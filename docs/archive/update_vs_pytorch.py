"""One TD3 update, ours against PyTorch, both in f32 and in bf16, in alternating rounds.

    pip install torch
    cargo build --release
    python docs/archive/update_vs_pytorch.py target/release/rher

Both do the same arithmetic: twin critics and an actor of 3 x 256 rectified units, 31 inputs,
4 actions, layer normalization in the critics, Adam, target smoothing, an actor step and moved
targets every second update.
PyTorch is used as its documentation has it: eager mode, Adam with foreach, and torch.autocast for
bf16. Ours is measured with `agent.precision` likewise. `--threads 2` counts time on the wall.
"""

import argparse
import json
import os
import statistics
import subprocess
import time

import torch
from torch import nn

INPUTS, ACTIONS, HIDDEN = 31, 4, (256, 256, 256)
DISCOUNT, RATE, TARGET_RATE, DELAY = 0.95, 1e-3, 0.01, 2
NOISE, NOISE_CLIP, ACTION_L2 = 0.2, 0.5, 1.0
WARM_UP, MEASURED = 0.5, 1.5  # seconds


def network(inputs, outputs, norm=False):
    widths = (inputs, *HIDDEN)
    layers = []
    for before, after in zip(widths, widths[1:]):
        layers += [nn.Linear(before, after), *([nn.LayerNorm(after)] if norm else []), nn.ReLU()]
    return nn.Sequential(*layers, nn.Linear(widths[-1], outputs))


class Learner:
    def __init__(self, precision):
        self.cast = torch.autocast("cpu", torch.bfloat16, enabled=precision == "bf16")
        self.actor = network(INPUTS, ACTIONS)
        self.critics = nn.ModuleList(network(INPUTS + ACTIONS, 1, norm=True) for _ in range(2))
        self.actor_target = network(INPUTS, ACTIONS)
        self.critics_target = nn.ModuleList(network(INPUTS + ACTIONS, 1, norm=True) for _ in range(2))
        self.actor_target.load_state_dict(self.actor.state_dict())
        self.critics_target.load_state_dict(self.critics.state_dict())
        self.actor_adam = torch.optim.Adam(self.actor.parameters(), lr=RATE, foreach=True)
        self.critic_adam = torch.optim.Adam(self.critics.parameters(), lr=RATE, foreach=True)
        self.online = [*self.actor.parameters(), *self.critics.parameters()]
        self.target = [*self.actor_target.parameters(), *self.critics_target.parameters()]
        self.updates = 0

    def update(self, states, actions, rewards, next_states):
        self.updates += 1
        with torch.no_grad(), self.cast:
            noise = (torch.randn_like(actions) * NOISE).clamp(-NOISE_CLIP, NOISE_CLIP)
            said = (torch.tanh(self.actor_target(next_states)) + noise).clamp(-1, 1)
            pair = torch.cat((next_states, said), 1)
            value = torch.min(*(critic(pair) for critic in self.critics_target))
            returns = (rewards + DISCOUNT * value).clamp(-1 / (1 - DISCOUNT), 0)
        pair = torch.cat((states, actions), 1)
        with self.cast:
            values = [critic(pair) for critic in self.critics]
        loss = sum(nn.functional.mse_loss(value.float(), returns.float()) for value in values)
        self.critic_adam.zero_grad()
        loss.backward()
        self.critic_adam.step()
        if self.updates % DELAY:
            return
        self.critics.requires_grad_(False)
        with self.cast:
            said = torch.tanh(self.actor(states))
            value = self.critics[0](torch.cat((states, said), 1))
        loss = ACTION_L2 * said.float().square().mean() - value.float().mean()
        self.actor_adam.zero_grad()
        loss.backward()
        self.actor_adam.step()
        self.critics.requires_grad_(True)
        with torch.no_grad():
            torch._foreach_lerp_(self.target, self.online, TARGET_RATE)


def pytorch(learner, batch, clock):
    """Milliseconds of one update."""
    rows = (
        torch.randn(batch, INPUTS),
        torch.rand(batch, ACTIONS) * 2 - 1,
        -torch.randint(0, 2, (batch, 1)).float(),
        torch.randn(batch, INPUTS),
    )
    for seconds in (WARM_UP, MEASURED):
        updates, wall, start = 0, time.perf_counter(), clock()
        while time.perf_counter() - wall < seconds:
            for _ in range(DELAY):
                learner.update(*rows)
            updates += DELAY
    return 1e3 * (clock() - start) / updates


def ours(rher, precision, batch, threads):
    """Milliseconds of one update."""
    command = f"{rher} bench update --engine fused --inputs {INPUTS} --json"
    command += f" --precision {precision} --threads {threads} --batch {batch}"
    printed = subprocess.run(command.split(), check=True, capture_output=True, text=True).stdout
    return json.loads(printed)[0]["cpu_ms_per_update" if threads == 1 else "mean_ms_per_update"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("rher", help="the program, built with `cargo build --release`")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--batch", type=int, nargs="+", default=[256, 2048])
    parser.add_argument("--threads", type=int, default=1)
    args = parser.parse_args()
    torch.set_num_threads(args.threads)
    clock = time.process_time if args.threads == 1 else time.perf_counter
    kind = "CPU" if args.threads == 1 else "wall"
    print(f"PyTorch {torch.__version__}, {args.threads} threads, {kind} ms per update:")
    print(f"medians of {args.rounds} rounds, and of the rounds' ratios with the extremes")
    for batch in args.batch:
        learners = {precision: Learner(precision) for precision in ("f32", "bf16")}
        times = {(who, precision): [] for who in ("ours", "PyTorch") for precision in learners}
        for _ in range(args.rounds):
            for precision, learner in learners.items():
                times["ours", precision].append(ours(args.rher, precision, batch, args.threads))
                times["PyTorch", precision].append(pytorch(learner, batch, clock))
        print(f"batch {batch}:")
        for (who, precision), values in times.items():
            print(f"    {who} {precision}: {statistics.median(values):.2f} ms")
        pairs = [(("ours", mine), ("PyTorch", theirs)) for mine in learners for theirs in learners]
        for mine, theirs in [*pairs, (("ours", "bf16"), ("ours", "f32"))]:
            ratios = [x / y for x, y in zip(times[mine], times[theirs])]
            print(
                f"    {' '.join(mine)} / {' '.join(theirs)}: "
                f"{statistics.median(ratios):.2f} ({min(ratios):.2f} to {max(ratios):.2f})"
            )


if __name__ == "__main__":
    main()
