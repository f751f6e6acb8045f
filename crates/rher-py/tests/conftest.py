"""What several files of tests use."""

import signal

import pytest

#: Settings with which a run takes a second or less.
TINY = {
    "agent.hidden": [16, 16],
    "replay.batch_size": 16,
    "replay.updates_per_episode": 2,
    "evaluation.every_episodes": 5,
    "evaluation.episodes": 5,
    "evaluation.subtask_episodes": 2,
}


@pytest.fixture(autouse=True, scope="session")
def ctrl_c():
    """Python leaves Ctrl-C alone where it was started in the background of a script."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def tiny():
    return dict(TINY)


@pytest.fixture
def out(tmp_path):
    return tmp_path / "run"
