"""Docstrings name what their objects have: a field or error renamed is renamed there too."""

import ast
import builtins
import re

from repository import ROOT

SECTION = re.compile(
    r"^(Parameters|Attributes)\n-+\n(.*?)(?=\n\n\w+\n-{3,}|\Z)", re.DOTALL | re.MULTILINE
)


def documented_names(docstring):
    """Return the names that head the descriptions of parameters and attributes."""
    heads = [
        line.split(" : ")[0]
        for section in SECTION.finditer(docstring)
        for line in section[2].splitlines()
        if line and not line.startswith(" ")
    ]
    return {name.strip(" *") for head in heads for name in head.split(",")} - {""}


def names_of(node):
    """Return a function's parameters; a class's fields, properties and what its init takes."""
    if not isinstance(node, ast.ClassDef):
        a = node.args
        taken = [*a.posonlyargs, *a.args, *a.kwonlyargs, a.vararg, a.kwarg]
        return {one.arg for one in taken if one}
    names = set()
    for member in node.body:
        if isinstance(member, ast.AnnAssign):
            names.add(member.target.id)
        elif isinstance(member, ast.FunctionDef):
            names |= {member.name} | (names_of(member) if member.name == "__init__" else set())
    return names


def stale_names(source):
    """Yield class or function, and the names in its docstring that it does not have."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            stale = documented_names(ast.get_docstring(node) or "") - names_of(node)
            if stale:
                yield node.name, stale


def test_documented_fields_and_parameters_exist():
    modules = sorted((ROOT / "src").rglob("*.py"))
    found = [
        (str(module.relative_to(ROOT)), *stale)
        for module in modules
        for stale in stale_names(module.read_text(encoding="utf-8"))
    ]
    assert found == []


def documented_errors(source):
    """Yield the names that head the descriptions of what is raised."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef):
            _, _, raised = (ast.get_docstring(node) or "").partition("Raises\n------\n")
            heads = re.findall(r"^(?!-)(\S.*)\n    ", raised.partition("\n\n")[0], re.MULTILINE)
            yield from (name.strip() for head in heads for name in head.split(","))


def test_documented_errors_exist():
    sources = [m.read_text(encoding="utf-8") for m in (ROOT / "src").rglob("*.py")]
    classes = {
        n.name for s in sources for n in ast.walk(ast.parse(s)) if isinstance(n, ast.ClassDef)
    }
    named = {name for source in sources for name in documented_errors(source)}
    assert len(named) > 8
    assert named - classes - {*dir(builtins), "LinAlgError"} == set()


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
    assert list(stale_names(source)) == [("Bolt", {"turned"})]
