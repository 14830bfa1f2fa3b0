"""The stubs are the module; the package and its examples are clean under `mypy --strict`."""

from __future__ import annotations

import ast
import doctest
import inspect
import subprocess
import sys
from pathlib import Path

import amacrine
import pytest
from amacrine import _amacrine

HERE = Path(__file__).resolve().parents[1]


def test_stubs_have_what_the_module_has() -> None:
    tree = ast.parse((HERE / "amacrine/_amacrine.pyi").read_text())
    stated: dict[str, ast.stmt] = {}
    for node in tree.body:
        if isinstance(node, (ast.ClassDef, ast.FunctionDef)):
            stated[node.name] = node
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            stated[node.target.id] = node
    there = {n for n in dir(_amacrine) if not n.startswith("__")} | {"__version__"}
    assert set(stated) == there - {"_amacrine"}
    for name, node in stated.items():
        of = getattr(_amacrine, name)
        if isinstance(node, ast.FunctionDef):
            assert _arguments(node) == _signature(of), name
        if isinstance(node, ast.ClassDef) and name != "Error":
            methods = {f.name: f for f in node.body if isinstance(f, ast.FunctionDef)}
            own = {n for n in vars(of) if not n.startswith("__")}
            assert {n for n in methods if n != "__new__"} == own, name
            for method, function in methods.items():
                if not function.decorator_list and method != "__new__":
                    got = _signature(getattr(of, method))
                    assert _arguments(function) == got, f"{name}.{method}"


def _arguments(node: ast.FunctionDef) -> list[str]:
    all = [a.arg.rstrip("_") for a in [*node.args.posonlyargs, *node.args.args]]
    return [a for a in all if a != "self"]


def _signature(of: object) -> list[str]:
    assert callable(of)
    all = inspect.signature(of).parameters
    return [name for name in all if name != "self"]


@pytest.mark.parametrize("what", ["amacrine", "examples", "tests"])
def test_mypy_is_content(what: str) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", what],
        cwd=HERE, capture_output=True, text=True,
    )
    assert done.returncode == 0, done.stdout


def test_everything_public_is_documented() -> None:
    for name in amacrine.__all__:
        of = getattr(amacrine, name)
        if inspect.isclass(of) or inspect.isfunction(of):
            assert of.__doc__, name
        if inspect.isclass(of) and of is not amacrine.Error:
            for method, it in vars(of).items():
                if not method.startswith("_") and (callable(it) or isinstance(it, property)):
                    assert getattr(it, "__doc__", None), f"{name}.{method}"


def test_functions_of_events_and_gradients_are_documented() -> None:
    for module in (amacrine.events, amacrine.gradient):
        for name, of in vars(module).items():
            own = getattr(of, "__module__", None) == module.__name__
            if own and callable(of) and not name.startswith("_"):
                assert of.__doc__, name


def test_the_first_lines_work() -> None:
    assert doctest.testmod(amacrine).failed == 0
