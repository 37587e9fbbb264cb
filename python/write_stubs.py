"""write_stubs.py FOLDER: writes __init__.pyi, what the compiled module says of its functions, beside it."""
import pathlib
import sys

import patinate

HEAD = '''"""How materials age: histories of photographs, transfers to meshes, simulation, comparison. Generated; help(patinate) says more."""
import os
from typing import Any, Callable, Literal, Mapping, Sequence

import numpy as np
import numpy.typing as npt

__version__: str

'''
pathlib.Path(sys.argv[1], "__init__.pyi").write_text(HEAD + patinate._native._stubs())
