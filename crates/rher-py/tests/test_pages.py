"""The Python of every page runs as it is written, from the top of the page to its bottom.

Trainings are made short, and what needs a cluster is only asked whether it takes such arguments.
"""

import contextlib
import inspect
import io
import os
import re
import subprocess
import sys
from pathlib import Path

import gymnasium
import numpy as np
import pytest
import rher
import rher.sweep
from conftest import TINY
from test_tails import STEPS, Knob

ROOT = Path(__file__).parents[3]
#: A block, and what the page says that it prints.
BLOCK = re.compile(r"```python\n(.*?)```(?:\n\nprints[^\n]*\n\n```text\n(.*?)```)?", re.DOTALL)
#: The reference is written by a program; its own test compiles it.
WRITTEN = "python-reference.md"
#: This page needs robots, which `test_robots_page.py` gives it.
ROBOTS = "robots.md"


def pages():
    """The chapters of the site that show Python."""
    summary = (ROOT / "docs/SUMMARY.md").read_text()
    chapters = [(ROOT / "docs" / name).resolve() for name in re.findall(r"\]\(([^)]+)\)", summary)]
    # Notes say what was run at their time.
    shown = [page for page in chapters if "archive" not in page.parts]
    shown = [page for page in shown if page.name not in (WRITTEN, ROBOTS)]
    return [page for page in shown if BLOCK.search(page.read_text())]


class Flip(gymnasium.ObservationWrapper):
    """Stands in for a task of panda-gym: as much before the position of what is turned."""

    def __init__(self):
        super().__init__(Knob(places=False, quaternion=True))
        spaces = dict(self.env.observation_space.spaces)
        low, high = spaces["observation"].low, spaces["observation"].high
        spaces["observation"] = gymnasium.spaces.Box(
            np.insert(low, [3] * 4, -1.0), np.insert(high, [3] * 4, 1.0), dtype=np.float64
        )
        self.observation_space = gymnasium.spaces.Dict(spaces)

    def observation(self, seen):
        return seen | {"observation": np.insert(seen["observation"], [3] * 4, 0.0)}


@pytest.fixture
def short(monkeypatch, tmp_path):
    """Makes trainings short, in a folder in which pages find what they take for granted."""
    gymnasium_robotics = pytest.importorskip("gymnasium_robotics")
    gymnasium.register_envs(gymnasium_robotics)
    if "PandaFlip-v3" not in gymnasium.registry:
        gymnasium.register("PandaFlip-v3", entry_point=Flip, max_episode_steps=STEPS)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "docs").symlink_to(ROOT / "docs")
    train, learn, init = rher.train, rher.Trainer.learn, rher.Trainer.__init__
    end = {"env_steps": 250}
    tiny = {"set": TINY}
    monkeypatch.setattr(rher, "train", lambda task, **given: train(task, **given | end | tiny))
    monkeypatch.setattr(
        rher.Trainer, "__init__", lambda self, env, **given: init(self, env, **given | tiny)
    )
    monkeypatch.setattr(rher.Trainer, "learn", lambda self, **given: learn(self, **given | end))

    def sweep(*given, **named):
        inspect.signature(sweep_on_ray).bind(*given, **named)
        return []

    sweep_on_ray = rher.sweep.run
    monkeypatch.setattr(rher.sweep, "run", sweep)
    train("push", seed=2, out="runs/push-rher-fast-2", **end, **tiny)


@pytest.mark.parametrize("page", pages(), ids=lambda page: str(page.relative_to(ROOT)))
@pytest.mark.filterwarnings("ignore")
def test_a_page_runs_from_top_to_bottom(page, short):
    names = {"__name__": "page"}
    for block in BLOCK.finditer(page.read_text()):
        code, expected = block.groups()
        printed = io.StringIO()
        line = page.read_text()[: block.start()].count("\n") + 1
        # Errors name the line of the page.
        code = compile("\n" * line + code, page, "exec")
        with contextlib.redirect_stdout(printed):
            exec(code, names)
        if expected is not None:
            assert printed.getvalue() == expected


def test_pages_are_found():
    found = {str(page.relative_to(ROOT)) for page in pages()}
    assert found >= {"README.md", "crates/rher-py/README.md", "docs/environment-python.md"}


def test_the_reference_is_what_the_package_says():
    pytest.importorskip("griffe")
    script = ROOT / "scripts/python-reference"
    written = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True)
    page = ROOT / "docs" / WRITTEN
    if "RHER_RENEW_DOCS" in os.environ:
        page.write_text(written.stdout)
    assert page.read_text() == written.stdout, (
        "renew it: RHER_RENEW_DOCS=1 pytest crates/rher-py/tests/test_pages.py -k reference"
    )
    for code, _ in BLOCK.findall(written.stdout):
        compile(code, page, "exec")
