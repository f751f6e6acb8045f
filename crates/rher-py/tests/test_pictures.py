"""Pictures and films of single and vector environments."""

import copy

import gymnasium
import numpy as np
import pytest
import rher


def test_vectors_show_what_single_environments_show():
    size = {"render_mode": "rgb_array", "width": 96, "height": 64}
    envs = gymnasium.make_vec("rher/Push-v0", num_envs=2, **size)
    with pytest.raises(rher.StateError, match="nothing to see"):
        envs.render()
    envs.reset(seed=4)
    pictures = envs.render()
    assert isinstance(pictures, tuple) and len(pictures) == 2
    for row, picture in enumerate(pictures):
        env = gymnasium.make("rher/Push-v0", **size)
        env.reset(seed=4 + row)
        assert picture.dtype == np.uint8 and np.array_equal(picture, env.render())
    assert np.array_equal(copy.deepcopy(envs).render(), pictures)
    envs.step(envs.action_space.sample())
    assert not np.array_equal(envs.render(), pictures)
    envs.close()
    with pytest.raises(rher.StateError, match="closed"):
        envs.render()
    assert gymnasium.make_vec("rher/Push-v0", num_envs=2).render() is None


def test_gymnasium_films_single_environments(tmp_path):
    pytest.importorskip("moviepy")
    size = {"render_mode": "rgb_array", "width": 96, "height": 64}
    env = gymnasium.make("rher/Push-v0", **size)
    env = gymnasium.wrappers.RecordVideo(env, str(tmp_path), episode_trigger=lambda _: True)
    env.reset(seed=0)
    while not env.step(env.action_space.sample())[3]:
        pass
    env.close()
    (film,) = tmp_path.glob("*.mp4")
    assert film.stat().st_size > 1000


def test_gymnasium_films_vectors(tmp_path):
    pytest.importorskip("moviepy")
    size = {"render_mode": "rgb_array", "width": 96, "height": 64}
    envs = gymnasium.make_vec("rher/Push-v0", num_envs=4, **size)
    envs = gymnasium.wrappers.vector.RecordVideo(envs, str(tmp_path), video_length=10)
    envs.reset(seed=0)
    for _ in range(12):
        envs.step(envs.action_space.sample())
    envs.close()
    (film,) = tmp_path.glob("*.mp4")
    assert film.stat().st_size > 1000
