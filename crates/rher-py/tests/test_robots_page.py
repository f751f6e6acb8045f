"""The Python of `docs/robots.md`, run on simulated robots."""

import re
import sys
from pathlib import Path

import pytest
from robot import SimulatedRobot
from slow_arm import SlowArm

HERE = Path(__file__).parent
PAGE = HERE / "../../../docs/robots.md"


@pytest.mark.skipif(not PAGE.exists(), reason="the page is not here")
def test_the_snippets_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(HERE.parent / "examples")
    import real_arm

    arm = SlowArm()

    class InItsTime(real_arm.RealArm):
        """Takes its time from the simulated arm."""

        def __init__(self, robot, *arguments, **settings):
            super().__init__(robot, *arguments, now=robot.now, sleep=robot.sleep, **settings)

    monkeypatch.setattr(real_arm, "RealArm", InItsTime)
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    assert len(blocks) == 4
    names = {"robot": SimulatedRobot(), "slow_arm": arm, "ask": lambda question: None}
    for block in blocks:
        exec(compile(block, str(PAGE), "exec"), names)  # noqa: S102
    printed = capsys.readouterr().out
    assert "25.0 actions a second" in printed
    # What the page says of the simulated hand.
    for axis in "xyz":
        went = names["went"][f"locked_fingers.{axis}"][f"gripper.position.{axis}"]
        assert round(went, 2) == 0.08
    assert names["held"] == 0
    assert names["trainer"].env_steps == 200
    assert names["env"].taken.steps > 200
    assert sys.modules["real_arm"] is real_arm
