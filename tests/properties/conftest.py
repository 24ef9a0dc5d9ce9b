"""Lets the tests of this folder use the oracle of the solve; in importlib mode pytest adds no folder to the path."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "solve"))
