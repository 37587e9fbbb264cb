"""write_stubs.py FOLDER: writes __init__.pyi, what the compiled module says of its functions, beside it."""
import pathlib
import sys

import patinate

HEAD = '''"""How materials age: histories of photographs, transfers to meshes, simulation, comparison. Generated; help(patinate) says more."""
import os
from typing import Any, Callable, Iterator, Literal, Mapping, Sequence

import numpy as np
import numpy.typing as npt

__version__: str

class Report(dict[str, Any]):
    """Results by name, as a dict and as attributes: report["figures"] is report.figures. Its figures are a table."""
    def __getattr__(self, name: str) -> Any: ...
    def rows(self) -> list[dict[str, Any]]:
        """Makes a table of the figures: one dict a figure (and time), with its part of the report, its name and its values."""
    def to_dataframe(self) -> Any:
        """Makes a pandas.DataFrame of rows(). Raises ImportError where pandas is not installed."""
'''
pathlib.Path(sys.argv[1], "__init__.pyi").write_text(HEAD + patinate._native._stubs())
