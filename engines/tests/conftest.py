"""Loads the Python engines that are set up; tests of the others are skipped."""

import importlib.util
import sys
from pathlib import Path

import pytest

ENGINES = Path(__file__).resolve().parent.parent


def load(name):
    """The module of engines/NAME/main.py; skips where its packages are missing."""
    folder = ENGINES / name
    sys.path.insert(0, str(folder))
    try:
        spec = importlib.util.spec_from_file_location(name.replace("-", "_"), folder / "main.py")
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    except SystemExit:
        pytest.skip(f"{name} is not set up: engines/set-up {name}")
    finally:
        sys.path.remove(str(folder))
    return module
