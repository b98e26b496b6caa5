"""Whoever looks up a public name finds a worked example, which the tests run."""

import doctest
import inspect
from importlib import import_module

import pytest

import omnivat
from omnivat import figures

OF_LIBRARY = [getattr(omnivat, name) for name in omnivat.__all__]
OF_FIGURES = [getattr(figures, name) for name in figures.__all__]
PUBLIC = [
    one for one in [*OF_LIBRARY, *OF_FIGURES] if inspect.isroutine(one) or inspect.isclass(one)
]


@pytest.mark.parametrize("shown", PUBLIC, ids=lambda one: f"{one.__module__}.{one.__qualname__}")
def test_a_public_function_or_class_shows_an_example_that_is_run(shown):
    run = [
        example
        for test in doctest.DocTestFinder().find(import_module(shown.__module__))
        if test.name == f"{shown.__module__}.{shown.__qualname__}"
        for example in test.examples
        if doctest.SKIP not in example.options
    ]
    assert run
