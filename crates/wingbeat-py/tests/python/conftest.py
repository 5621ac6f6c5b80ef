"""What the tests share."""

import os
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[4]
SHORT = {"flight.duration_s": 0.1}


@pytest.fixture(scope="session")
def program():
    """Runs the program; its outcome."""
    path = os.environ.get("WINGBEAT_PROGRAM", ROOT / "target/release/wingbeat")

    def run(*arguments, cwd=ROOT):
        return subprocess.run([path, *map(str, arguments)], cwd=cwd, capture_output=True, text=True)

    return run


@pytest.fixture
def turn():
    """The banking turn that comes with the package."""
    import wingbeat

    return wingbeat.shipped("scenarios/banking_turn.toml")
