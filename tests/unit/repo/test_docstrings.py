"""Docstrings name what their objects have: a field or error renamed is renamed there too."""

import ast
import builtins
import concurrent.futures
import doctest
import importlib
import re

import pytest
from repository import ROOT

SECTION = re.compile(
    r"^(Parameters|Attributes)\n-+\n(.*?)(?=\n\n\w+\n-{3,}|\Z)", re.DOTALL | re.MULTILINE
)


@pytest.fixture(scope="module")
def modules():
    """The package's modules by their paths, parsed."""
    package = ROOT / "src" / "cardan"
    return {
        str(file.relative_to(package).with_suffix("")): ast.parse(file.read_text(encoding="utf-8"))
        for file in sorted(package.rglob("*.py"))
    }


@pytest.fixture(scope="module")
def definitions(modules):
    """Classes and functions of the package, each with its module."""
    return [(name, node) for name, tree in modules.items() for node in definitions_of(tree)]


def definitions_of(tree):
    """Return a module's classes and functions, those of classes too."""
    return [n for n in ast.walk(tree) if isinstance(n, ast.ClassDef | ast.FunctionDef)]


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
    assert [stale_names(node) for node in definitions_of(ast.parse(source))] == [{"turned"}]


def modules_with_examples():
    """Return the names of the package's modules whose docstrings have examples."""
    for file in sorted((ROOT / "src").rglob("*.py")):
        if ">>>" in file.read_text(encoding="utf-8"):
            yield ".".join(file.relative_to(ROOT / "src").with_suffix("").parts)


def test_examples_in_docstrings_run_and_print_what_they_say():
    tried = [doctest.testmod(importlib.import_module(name)) for name in modules_with_examples()]
    assert sum(one.attempted for one in tried) > 25
    assert sum(one.failed for one in tried) == 0


QUOTED = re.compile(r"`([A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*)`")


def names_and_quotes(tree):
    """Return what a module defines, every name its code has, and what its docstrings quote."""
    defined, used, quoted = set(), set(), set()
    docs = {id(n.value) for n in ast.walk(tree) if isinstance(n, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant):
            if isinstance(node.value, str) and id(node) in docs:
                quoted |= set(QUOTED.findall(node.value))
            elif isinstance(node.value, str) and "\n" not in node.value:
                used |= set(re.findall(r"\w+", node.value))
            continue
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            defined.add(node.name)
        elif isinstance(node, ast.AnnAssign | ast.Assign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            defined |= {t.id for t in targets if isinstance(t, ast.Name)}
        for field in ("name", "id", "attr", "arg", "module"):
            if isinstance(name := getattr(node, field, None), str):
                used |= set(name.split("."))
    return defined, used, quoted


def unknown_references(trees, keys):
    """Return what docstrings quote as a name of code that neither package nor file has."""
    each = {name: names_and_quotes(tree) for name, tree in trees.items()}
    known = {part for name in trees for part in name.split("/")} | keys | {*dir(builtins)}
    known = known.union(*(defined for defined, _, _ in each.values()))
    for name, (_, used, quoted) in each.items():
        own = known | used
        yield from (f"{name}: {q}" for q in sorted(quoted) if not own.issuperset(q.split(".")))


FOREIGN = {
    "Comment", "Fs", "PLAIN", "PageHeader", "RigidTruck", "S1_MPa", "SIGNAL", "SPN190",
    "SampleRate", "Size", "Time_ms", "VERT_UNITS", "binlog_objects.h", "cn_sync_type",
    "collector_day.py", "dz_zip_type", "functools.partial", "metals.csv", "outer_in", "outer_m",
    "SCALE.CHAN_n", "test_composite", "whos", "_in", "_kN_m", "_m",
}  # fmt: skip
"""Quoted names of file formats, standards, other libraries and tests."""


def test_names_quoted_in_docstrings_exist(modules):
    package = ROOT / "src" / "cardan"
    data = (f for kind in ("yaml", "json") for f in package.rglob(f"*.{kind}"))
    keys = {w for f in data for w in re.findall(r"\w+", f.read_text(encoding="utf-8"))}
    found = set(unknown_references(modules, keys))
    assert sorted(one for one in found if one.partition(": ")[2] not in FOREIGN) == []
    assert FOREIGN - {one.partition(": ")[2] for one in found} == set()


def test_renamed_function_is_found_where_it_is_quoted():
    trees = {
        "a/joints": ast.parse('def swing(x):\n    """Return the swing."""\n'),
        "a/lines": ast.parse('def line(y):\n    """As `swing`, of `y`; not `halves`."""\n'),
    }
    assert list(unknown_references(trees, set())) == ["a/lines: halves"]
