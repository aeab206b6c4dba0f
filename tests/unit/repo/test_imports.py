"""Modules import downwards only, never in a circle, and no private name of another folder."""

import ast
import math
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from repository import ROOT

SOURCE = ROOT / "src"

PRESENTER_WORDS = ("presentation", "chapter", "scene", "report", "phrases", "table", "statement")
"""Words in the names of a topic's modules that may import `render`."""


def imports(package: Path) -> dict[str, set[tuple[str, str]]]:
    """What each module of a package imports of it, (module, name): top, lazy and for types."""
    files = {
        ".".join(p.relative_to(package.parent).with_suffix("").parts).removesuffix(".__init__"): p
        for p in package.rglob("*.py")
    }
    found: dict[str, set[tuple[str, str]]] = {}
    for module, file in files.items():
        found[module] = set()
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                assert node.level == 0, f"{module} imports relatively"
                for name in (a.name for a in node.names):
                    inner = f"{node.module}.{name}"
                    if inner in files:
                        found[module].add((inner, ""))
                    elif node.module in files:
                        found[module].add((node.module, name))
            elif isinstance(node, ast.Import):
                found[module] |= {(a.name, "") for a in node.names if a.name in files}
    return found


def circles(graph: dict[str, set[str]]) -> list[set[str]]:
    """Groups of modules that import each other in a circle."""
    reached: dict[str, set[str]] = {}
    for module in graph:
        seen, todo = set(), [module]
        while todo:
            todo += [m for m in graph[todo.pop()] if m not in seen and not seen.add(m)]
        reached[module] = seen
    found = [
        frozenset({m, *(n for n in reached[m] if m in reached[n])})
        for m in graph if m in reached[m]
    ]  # fmt: skip
    return [set(one) for one in dict.fromkeys(found)]


@pytest.fixture(scope="module")
def cardan_imports() -> dict[str, set[tuple[str, str]]]:
    return imports(SOURCE / "cardan")


def layer_ranks() -> dict[str, int]:
    """Rank of each top folder by the layers of pyproject.toml, the highest first."""
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    contract = tomllib.loads(text)["tool"]["importlinter"]["contracts"][0]
    return {
        name.strip(): rank
        for rank, layer in enumerate(contract["layers"])
        for name in layer.split("|")
    }


def folder(module: str) -> str:
    """Top folder of a module, or itself where it lies beside the folders."""
    return module.split(".")[1] if "." in module else ""


def upward(graph: dict[str, set[tuple[str, str]]]) -> list[tuple[str, str]]:
    """Imports from a layer to one above it or beside it."""
    rank = layer_ranks()
    return sorted(
        (importer, imported)
        for importer, every in graph.items()
        for imported, _ in every
        if folder(importer) and folder(imported) and folder(importer) != folder(imported)
        and rank[folder(importer)] >= rank[folder(imported)]
    )  # fmt: skip


def foreign_private(graph: dict[str, set[tuple[str, str]]]) -> list[tuple[str, str, str]]:
    """Private names that a module imports from another folder."""
    return sorted(
        (importer, imported, name)
        for importer, every in graph.items()
        for imported, name in every
        if name.startswith("_") and not name.startswith("__")
        and importer.rpartition(".")[0] != imported.rpartition(".")[0]
    )  # fmt: skip


def between_topics(graph: dict[str, set[tuple[str, str]]]) -> set[tuple[str, str]]:
    """Pairs of topics of which one imports the other."""
    pairs = {
        (importer.split(".")[2], imported.split(".")[2])
        for importer, every in graph.items()
        for imported, _ in every
        if importer.count(".") > 2 and imported.count(".") > 2
        and folder(importer) == folder(imported) == "topics"
    }  # fmt: skip
    return {(a, b) for a, b in pairs if a != b}


def test_no_modules_import_each_other_in_a_circle(cardan_imports):
    graph = {module: {m for m, _ in every} for module, every in cardan_imports.items()}
    assert circles(graph) == []


def test_modules_import_lower_layers_only(cardan_imports):
    assert upward(cardan_imports) == []


def test_private_names_stay_in_their_folder(cardan_imports):
    assert foreign_private(cardan_imports) == []


def test_topics_import_no_other_topic(cardan_imports):
    assert between_topics(cardan_imports) == set()


def test_import_contracts_have_no_exceptions():
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    contracts = tomllib.loads(text)["tool"]["importlinter"]["contracts"]
    assert [c["name"] for c in contracts if "ignore_imports" in c] == []


def test_no_module_imports_the_package_itself(cardan_imports):
    """The package names its interface: to import it is to import everything."""
    assert [m for m, every in cardan_imports.items() if "cardan" in {i for i, _ in every}] == []


def test_only_presenters_of_topics_import_render(cardan_imports):
    importers = {
        importer
        for importer, every in cardan_imports.items()
        for imported, _ in every
        if folder(importer) == "topics" and folder(imported) == "render"
    }
    assert sorted(
        m for m in importers if not any(w in m.rpartition(".")[2] for w in PRESENTER_WORDS)
    ) == []  # fmt: skip


def test_documents_name_no_topic_but_those_of_every_approval(cardan_imports):
    """Corrections, yoke phases and part selection belong to every application; studies do not."""
    topics = {
        imported.split(".")[2]
        for importer, every in cardan_imports.items()
        for imported, _ in every
        if folder(importer) == "documents" and folder(imported) == "topics"
    }
    assert topics == {"design"}


def test_faults_are_found(tmp_path):
    """A lazy circle, an upward import, a private name and a topic's topic are all found."""
    wrong = {
        "__init__.py": "",
        "core/__init__.py": "",
        "core/units.py": "def f():\n    from cardan.core.labels import a\n",
        "core/labels.py": "from cardan.core import units\nfrom cardan.model.parts import _b\n",
        "model/__init__.py": "",
        "model/parts.py": "_b = 1\n",
        "topics/__init__.py": "",
        "topics/joint/__init__.py": "",
        "topics/joint/one.py": "if TYPE_CHECKING:\n    import cardan.topics.torsion.two\n",
        "topics/torsion/__init__.py": "",
        "topics/torsion/two.py": "",
    }
    for name, text in wrong.items():
        file = tmp_path / "cardan" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    found = imports(tmp_path / "cardan")
    graph = {module: {m for m, _ in every} for module, every in found.items()}
    assert circles(graph) == [{"cardan.core.units", "cardan.core.labels"}]
    assert upward(found) == [("cardan.core.labels", "cardan.model.parts")]
    assert foreign_private(found) == [("cardan.core.labels", "cardan.model.parts", "_b")]
    assert between_topics(found) == {("joint", "torsion")}


@pytest.mark.slow
def test_life_without_application_loads_no_driveline_physics(tmp_path):
    """A recording of gauges alone waits neither for joints and loads nor for their checks."""
    rows = "".join(f"{k / 500},{50 * math.sin(k / 7)}\n" for k in range(5000))
    (tmp_path / "road.csv").write_text(f"time_s,gauge_MPa\n{rows}", encoding="utf-8")
    code = (
        "import sys; from cardan.cli import cli; "
        "cli(['life', 'road.csv', '--gauge', 'gauge_MPa', '--sn', '100,1e6,5'], "
        "standalone_mode=False)"
    )
    ending = (
        "\nfinally:\n print([m for m in sys.modules if m.startswith(('cardan.checks', "
        "'cardan.physics.kinematics', 'cardan.physics.vehicle', 'cardan.physics.loads'))])"
    )
    done = subprocess.run(
        [sys.executable, "-c", "import sys\ntry:\n " + code + ending],
        capture_output=True, text=True, check=False, cwd=tmp_path, encoding="utf-8",
        env={**os.environ, "PYTHONPATH": str(SOURCE), "PYTHONIOENCODING": "utf-8"},
    )  # fmt: skip
    assert "gauge_MPa" in done.stdout, done.stderr
    assert done.stdout.splitlines()[-1] == "[]"
