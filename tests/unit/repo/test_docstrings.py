"""Docstrings name what their objects have: a field or error renamed is renamed there too."""

import ast
import builtins
import concurrent.futures
import re

import pytest
from repository import ROOT

SECTION = re.compile(
    r"^(Parameters|Attributes)\n-+\n(.*?)(?=\n\n\w+\n-{3,}|\Z)", re.DOTALL | re.MULTILINE
)


@pytest.fixture(scope="module")
def definitions():
    """Classes and functions of the package, each with its module."""
    return [
        (str(module.relative_to(ROOT)), node)
        for module in sorted((ROOT / "src").rglob("*.py"))
        for node in definitions_of(module.read_text(encoding="utf-8"))
    ]


def definitions_of(source):
    """Return a module's classes and functions, those of classes too."""
    return [n for n in ast.walk(ast.parse(source)) if isinstance(n, ast.ClassDef | ast.FunctionDef)]


def documented_names(docstring):
    """Return the names that head the descriptions of parameters and attributes."""
    heads = [
        line.split(" : ")[0]
        for section in SECTION.finditer(docstring)
        for line in section[2].splitlines()
        if line and not line.startswith(" ")
    ]
    return {name.strip(" *") for head in heads for name in head.split(",")} - {""}


def documented_errors(docstring):
    """Return the names that head the descriptions of what is raised."""
    raised = docstring.partition("Raises\n------\n")[2].partition("\n\n")[0]
    heads = re.findall(r"^(\S.*)\n    ", raised, re.MULTILINE)
    return {name.strip() for head in heads for name in head.split(",")}


def names_of(node):
    """Return a function's parameters; a class's fields, properties and what its methods set."""
    if isinstance(node, ast.FunctionDef):
        a = node.args
        taken = [*a.posonlyargs, *a.args, *a.kwonlyargs, a.vararg, a.kwarg]
        return {one.arg for one in taken if one}
    names = set()
    for member in node.body:
        if isinstance(member, ast.AnnAssign):
            names.add(member.target.id)
        elif isinstance(member, ast.FunctionDef):
            names |= {member.name} | (names_of(member) if member.name == "__init__" else set())
            names |= {
                n.attr
                for n in ast.walk(member)
                if isinstance(n, ast.Attribute) and isinstance(n.ctx, ast.Store)
            }
    return names


def stale_names(node):
    """Return the names in a docstring that its class or function does not have."""
    return documented_names(ast.get_docstring(node) or "") - names_of(node)


def test_documented_fields_and_parameters_exist(definitions):
    found = [(module, node.name, stale_names(node)) for module, node in definitions]
    assert [entry for entry in found if entry[2]] == []


def test_documented_errors_exist(definitions):
    classes = {node.name for _, node in definitions if isinstance(node, ast.ClassDef)}
    named = set().union(*(documented_errors(ast.get_docstring(n) or "") for _, n in definitions))
    assert len(named) > 8
    assert named - classes - {*dir(builtins), *dir(concurrent.futures), "LinAlgError"} == set()


def test_renamed_field_is_found_in_docstring():
    source = '''
class Bolt:
    """A bolt.

    Attributes
    ----------
    preload, size : N, m
        Force and thread.
    turned
        Renamed.
    """

    preload: float
    size: float
'''
    assert [stale_names(node) for node in definitions_of(source)] == [{"turned"}]
