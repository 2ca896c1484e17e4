"""Runs the examples of docstrings."""

import doctest
from typing import Any


def run_examples(documented: Any) -> None:
    """Run the examples in the docstring of an object, of which there must be one."""
    name = documented.__name__
    test = doctest.DocTestParser().get_doctest(documented.__doc__, {}, name, None, None)
    assert test.examples, f"{name} has no example"
    printed: list[str] = []
    doctest.DocTestRunner().run(test, out=printed.append)
    assert not printed, "".join(printed)
