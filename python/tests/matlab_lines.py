"""Lines of MATLAB that call Python, as lines of Python.

Covers the forms on the handbook's page "From MATLAB", and no others: calls with `py.`, `pyargs`, cells of arguments, fields, indices, `end`-less ranges
over all, and `...` at the end of a line. What MATLAB itself does with data is stood in for by the classes below, which say what its manual says.
"""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io

ALL = slice(None)


class Value:
    """A variable of MATLAB: its fields are attributes, and its elements are counted from 1, in round brackets."""

    def __init__(self, content: Any) -> None:
        self.content = content

    def __getattr__(self, field: str) -> Any:
        content = self.content
        if isinstance(content, scipy.io.matlab.mat_struct):
            return wrapped(getattr(content, field))
        try:
            return wrapped(content[field])
        except (KeyError, IndexError, TypeError):
            raise AttributeError(field) from None

    def __call__(self, index: Any, columns: slice | None = None) -> Any:
        if columns is not None:
            return wrapped(self.content[index])
        elements = self.content if isinstance(self.content, list | np.ndarray) else [self.content]
        return wrapped(elements[index - 1])

    def __eq__(self, other: object) -> Any:
        return self.content == other

    __hash__ = None  # type: ignore[assignment]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Any:
        return np.asarray(self.content, dtype)


def wrapped(content: Any) -> Any:
    """Returns structs, tables and arrays as variables of MATLAB, and numbers and texts as they are."""
    return content if isinstance(content, str | int | float) or np.isscalar(content) else Value(content)


def pyargs(*names_and_values: Any) -> dict[str, Any]:
    return dict(zip(names_and_values[::2], names_and_values[1::2], strict=True))


def statements(block: str) -> Iterator[str]:
    """Returns the lines of a block with continued ones joined, without comments."""
    for line in re.sub(r"\.\.\.\s*\n\s*", "", block).splitlines():
        if line.strip() and not line.lstrip().startswith("%"):
            yield line.strip().rstrip(";")


def outside_texts(line: str, pattern: str, replacement: str) -> str:
    """Replaces a pattern in a line, except within its quoted texts."""
    parts = re.split(r'("[^"]*")', line)
    return "".join(part if part.startswith('"') else re.sub(pattern, replacement, part) for part in parts)


def python(line: str) -> str:
    """Returns a line of MATLAB in Python."""
    line = outside_texts(line, r"(\w)\{(\d+)\}", r"\1[\2 - 1]")
    line = outside_texts(line, r"\{", "[")
    line = outside_texts(line, r"\}", "]")
    line = outside_texts(line, r", :\)", ", ALL)")
    line = outside_texts(line, r"\bpyargs\(", "**pyargs(")
    line = outside_texts(line, r"\bpy\.(tuple|list)\(", r"\1(")
    return outside_texts(line, r"\bpy\.", "")


def namespace(folder: Path, printed: list[str]) -> dict[str, Any]:
    """Returns the functions of MATLAB that the page uses, for a session in a folder; `disp` appends to `printed`."""
    import pathlib

    import pyarrow
    import pyarrow.parquet
    import friction_bench

    names: dict[str, Any] = {
        "ALL": ALL, "numpy": np, "pyarrow": pyarrow, "friction_bench": friction_bench, "pathlib": pathlib, "pyargs": pyargs,
        "string": str, "double": lambda array: np.asarray(array, np.float64), "complex": lambda re, im: re + 1j * im,
        "jsondecode": lambda text: Value(json.loads(text)), "mean": np.mean, "abs": np.abs,
        "disp": lambda value: printed.append(str(value)), "plot": lambda x, y: printed.append(f"plot of {len(x)} and {len(y)}"),
        "parquetread": lambda file: Value(pyarrow.parquet.read_table(folder / file).to_pandas()),
    }

    def load(file: str) -> None:
        content = scipy.io.loadmat(folder / file, struct_as_record=False, squeeze_me=True)
        names["recording"] = Value(content["recording"])

    names["load"] = load
    return names
