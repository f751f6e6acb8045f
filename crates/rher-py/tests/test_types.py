"""What type checkers say of the snippets that users copy."""

import json
import re
import shutil
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1]
PAGES = {"package.py": PACKAGE / "README.md", "project.py": PACKAGE / "../../README.md"}


@pytest.fixture(scope="module")
def snippets(tmp_path_factory):
    """The Python of each page, in one file for each."""
    folder = tmp_path_factory.mktemp("snippets")
    for name, page in PAGES.items():
        blocks = re.findall(r"```python\n(.*?)```", page.read_text(), re.DOTALL)
        assert blocks, f"{page} shows no Python"
        (folder / name).write_text("\n".join(blocks))
    return folder


def checked(command, folder):
    """What a checker says of the files, or of one that has a mistake."""
    said = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    return said.returncode, said.stdout + said.stderr


def add_mistake(folder):
    (folder / "wrong.py").write_text('import rher\n\nrher.train("push", env_steps="many")\n')


def test_mypy_accepts_them(snippets, tmp_path):
    mypy = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path)]
    status, said = checked([*mypy, *PAGES], snippets)
    assert status == 0, said
    add_mistake(snippets)
    status, said = checked([*mypy, "wrong.py"], snippets)
    assert status == 1 and 'incompatible type "str"; expected "int | None"' in said


def test_pyright_accepts_them(snippets):
    pyright = [sys.executable, "-m", "pyright", "--pythonpath", sys.executable]
    try:
        import pyright as _  # noqa: F401
    except ImportError:
        skip("the package `pyright` is not installed")
    if shutil.which("node") is None:
        skip("pyright needs node, which is not installed")
    if checked([*pyright, "--version"], snippets)[0] != 0:
        skip("pyright cannot fetch its program from npm: there is no network")
    config = {"typeCheckingMode": "strict", "include": list(PAGES)}
    (snippets / "pyrightconfig.json").write_text(json.dumps(config))
    status, said = checked(pyright, snippets)
    assert status == 0, said
    add_mistake(snippets)
    status, said = checked([*pyright, "wrong.py"], snippets)
    assert status == 1 and "reportArgumentType" in said


def skip(why):
    """Skips a test so that nobody overlooks it."""
    warnings.warn(f"the snippets were not checked with pyright: {why}", stacklevel=1)
    pytest.skip(why)
