"""What is said in other languages: nothing is missing, numbers agree, one word for one thing."""

import ast
import importlib
import pkgutil
import re

import pytest
from click.testing import CliRunner
from repository import ROOT

import cardan
from cardan.application import limit_profiles as limit
from cardan.application import reader, templates
from cardan.application.duty_cycles import duty_cycle_names as cycles
from cardan.application.duty_cycles import load_duty_cycle
from cardan.application.plausibility import PLAUSIBILITY_RULES
from cardan.checks.quantities.registry import QUANTITIES
from cardan.cli import cli
from cardan.core.errors import DesignError, InvalidFileError
from cardan.core.provenance import SOURCE_ASSUMED
from cardan.core.units import mm
from cardan.physics.fem.cost_estimate import ModelSize, check_affordable
from cardan.render import i18n as language
from cardan.render.i18n import ENGLISH, LANGUAGE_CODES, Translator, message_catalogue
from cardan.schema.field_types import ListField, MappingField, TextField
from cardan.schema.tables import Table, TableField
from cardan.topics.recording.campaign_schema import (
    AdditionalRecordingFileTable,
    CampaignRecordingTable,
    CampaignTable,
    ChannelTable,
    GaugeFatigueStrengthTable,
    SegmentTable,
)

OTHERS = LANGUAGE_CODES[1:]


def test_untranslated_text_falls_back_to_english():
    language.UNTRANSLATED_MESSAGES_SEEN.clear()
    assert Translator("it")("nobody ever wrote this {n}", n=2) == "nobody ever wrote this 2"
    assert {("it", "nobody ever wrote this {n}")} == language.UNTRANSLATED_MESSAGES_SEEN
    assert Translator("pt").count("{count} moose", "{count} mooses", 2) == "2 mooses"


@pytest.mark.parametrize(
    ("code", "count", "said"),
    [
        ("en", 1, "1 shaft"), ("en", 2, "2 shafts"), ("en", 0, "0 shafts"),
        ("pt", 0, "0 cardan"), ("pt", 1, "1 cardan"), ("pt", 2, "2 cardans"),
        ("it", 0, "0 alberi"), ("it", 1, "1 albero"), ("it", 3, "3 alberi"),
    ],
)  # fmt: skip
def test_plural_forms_agree_with_count(code, count, said):
    """Portuguese counts zero with one, Italian with many."""
    assert Translator(code).count("{count} shaft", "{count} shafts", count) == said


def test_text_with_plural_forms_is_translated_without_count():
    assert Translator("it")("{count} shaft", count=7) == "7 alberi"


def sources():
    """Every source and note that a report may print."""
    for name in limit.profile_names():
        yield from (str(one.source) for one in limit.load_profile(name)[1])
    yield from (str(load_duty_cycle(name).source) for name in cycles())
    yield from (str(q.source) for q in QUANTITIES.values())
    yield str(SOURCE_ASSUMED)


@pytest.mark.parametrize("code", OTHERS)
def test_every_quantity_has_translated_name(code):
    assert [
        q.name for q in QUANTITIES.values() if ("quantity", q.name) not in message_catalogue(code)
    ] == []


@pytest.mark.parametrize("code", OTHERS)
def test_relations_between_values_are_translated(code):
    say = Translator(code)
    texts = {t for r in PLAUSIBILITY_RULES for t in (r.hint, "" if r.message else r.description)}
    assert [t for t in texts if t and say.error(t) == t] == []


@pytest.mark.parametrize("code", OTHERS)
def test_source_remarks_are_translated(code):
    """Titles of publications begin with a capital or a digit; what does not is ours to say."""
    said = set(sources())
    assert len(said) > 60
    pieces = {
        piece
        for text in said if ("", text) not in message_catalogue(code)
        for piece in language._SOURCE_SEPARATORS.split(text)[::2]
    }  # fmt: skip
    ours = {
        p for p in pieces
        if re.match("[a-z]|Assumed|Engineering|By ", p)
        and not re.match(r"(normal|maximum|rev\.) ?\S+$", p)
    }  # fmt: skip
    assert len(ours) > 25
    assert sorted(p for p in ours if ("", p) not in message_catalogue(code)) == []


def test_source_citation_is_translated_piece_by_piece():
    say = Translator("pt")
    said = (
        "normal 0.67 (safety 1.5): Engineering judgement, assumed; maximum 1: Dana, Rating, table 2"
    )
    assert say.source(said) == (
        "normal 0,67 (segurança 1,5): Critério interno, adotado; máximo 1: Dana, Rating, tabela 2"
    )
    assert ENGLISH.source(said) == said


def words(text):
    return set(re.findall(r"[^\W\d_]+", text.lower()))


@pytest.mark.parametrize(
    ("code", "english", "unless", "asked", "never"),
    [
        # The shaft is the cardan, as Souza (2014) writes; the axle is the eixo.
        ("pt", {"shaft", "shafts"}, set(), "", {"árvore", "árvores"}),
        ("pt", {"shaft", "shafts"}, {"half", "axle", "axles", "axis", "through"}, "cardan", set()),
        ("pt", {"windup", "wind"}, set(), "windup", {"torção"}),
        ("it", {"wind"}, set(), "wind-up", {"torce"}),
        ("pt", {"yokes"}, set(), "", {"cruzados", "cruzadas"}),
        ("it", {"yokes"}, set(), "", {"incrociate"}),
        ("it", {"judgement"}, set(), "criterio interno", {"prassi"}),
        ("pt", {"judgement"}, set(), "critério interno", set()),
        ("it", {"plan"}, set(), "in pianta", set()),
        ("pt", {"shim"}, set(), "calço", set()),
        ("it", {"shim"}, set(), "spessore", set()),
        ("pt", {"assumed"}, set(), "", {"suposto", "suposta", "supostos", "supostas"}),
        ("pt", {"coast", "coasting", "overrun"}, set(), "freio-motor", {"arrasto"}),
        ("pt", {"pitch"}, set(), "inclina", {"rotação"}),
        ("pt", {"recording"}, set(), "", {"gravação"}),
        ("pt", {"gearbox"}, set(), "", {"caixa"}),
        ("it", {"shaft", "shafts"}, {"half", "axle", "axles"}, "", {"ponte", "assale"}),
        ("it", {"coast", "coasting", "overrun"}, set(), "rilasci", set()),
        ("it", {"needle", "needles"}, set(), "rullini", {"aghi"}),
        ("it", {"assumed"}, set(), "", {"supposto", "supposti", "ipotizzato", "ipotizzati"}),
        # What is exceeded is superato: a stale result is not.
        ("it", {"stale"}, set(), "aggiornat", {"superato", "superati", "superate"}),
        ("it", {"rpm"}, set(), "rpm", {"giri"}),
    ],
)  # fmt: skip
def test_each_term_has_one_translation(code, english, unless, asked, never):
    texts = {e: t for (context, e), t in message_catalogue(code).items() if context != "error"}
    about = {e: t for e, t in texts.items() if words(re.sub(r"{\w+}", "", e)) & english - unless}
    about = {e: t for e, t in about.items() if not words(e) & unless and "`" not in e}
    assert about
    wrong = {e: t for e, t in about.items() if asked not in t.lower() or words(t) & never}
    assert wrong == {}


def refusals():
    """Sentences that readers write out where they refuse something; {0} is what is named."""
    for folder in ("schema", "application", "topics", "readers"):
        for module in sorted((ROOT / "src/cardan" / folder).rglob("*.py")):
            for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))):
                name = (
                    ast.unparse(node.func).rpartition(".")[2] if isinstance(node, ast.Call) else ""
                )
                if name in ("add_issue", "reject", "warn"):
                    yield from filter(None, map(sentence, node.args))


def sentence(node):
    """A text as a pattern, or nothing where it is none or says too little."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value if " " in node.value.strip() else ""
    if isinstance(node, ast.JoinedStr):
        parts, named = [], 0
        for part in node.values:
            if isinstance(part, ast.Constant):
                parts.append(part.value)
            else:
                parts.append(f"{{{named}}}")
                named += 1
        said = "".join(parts)
        return said if len(re.findall(r"[a-z]{3,}", said)) > 1 else ""
    return ""


@pytest.mark.slow
@pytest.mark.parametrize("code", OTHERS)
def test_application_reader_errors_are_translated(code):
    said = set(refusals())
    assert len(said) > 80
    missing = sorted(s for s in said if ("error", s) not in message_catalogue(code))
    # What is missing is said in English. New sentences come faster than translations; not too many.
    assert len(missing) <= 0.1 * len(said), missing


RECORDED = (
    "readers/*.py",
    "topics/recording/bearing_model.py",
    "topics/recording/campaign_schema.py",
    "topics/recording/campaign_study.py",
    "topics/recording/channel_reading.py",
    "topics/recording/options.py",
    "topics/recording/parameter_identification.py",
    "topics/recording/shaft_signals.py",
    "topics/recording/study.py",
    "cli/life.py",
    "physics/signals/shaft_angle.py",
    "physics/signals/conditioning.py",
    "physics/signals/recording.py",
)
REFUSED = (
    "unreadable_recording_error", "reject", "InvalidFileError", "BadParameter", "CardanError",
    "DesignError", "FileIssue",
)  # fmt: skip


BRACKETS = (
    "model/bracket.py", "physics/fem/*.py", "topics/bracket/*assess*.py",
    "topics/bracket/forced_response.py", "topics/bracket/life.py", "topics/bracket/optimisation.py",
)  # fmt: skip
CALLED = {
    "elements need a size above 0, got {0} m", "no face is called {0}; there are {1}",
    "nothing is called {0}; there are {1}", "{0} gauges have an influence, {1} a reading",
    "a load history is (..., samples, 3, 6 or {0}), got {1}",
    "elements of {0} mm, degree {1}, would make {2}; allowed are {3} GB and {4} minutes: ",
}  # fmt: skip
"""What only who calls the functions of a bracket is told; and the half of a sentence."""


def recordings_refused(modules=RECORDED):
    """Sentences in which readers of recordings and campaigns refuse, made before or in the call."""
    for module in (path for glob in modules for path in (ROOT / "src/cardan").glob(glob)):
        for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))):
            match node:
                case ast.Assign(
                    targets=[ast.Name("msg" | "message" | "hint" | "note")], value=value
                ):
                    yield from written(value)
                case ast.Call(func=func, args=args, keywords=more):
                    if ast.unparse(func).rpartition(".")[2] in (*REFUSED, "wrong"):
                        known = [k.value for k in more if k.arg in ("message", "hint")]
                        for value in (*args, *known):
                            yield from written(value)
                case _:
                    pass


def written(value):
    """Sentences of an expression, those it chooses among or puts together too."""
    match value:
        case ast.IfExp(body=one, orelse=other) | ast.BinOp(left=one, right=other):
            yield from (*written(one), *written(other))
        case _ if said := sentence(value):
            yield said


@pytest.mark.slow
@pytest.mark.parametrize("code", OTHERS)
def test_recording_reader_errors_are_translated(code):
    said = set(recordings_refused())
    assert len(said) > 90
    assert sorted(s for s in said if ("error", s) not in message_catalogue(code)) == []


@pytest.mark.parametrize("code", OTHERS)
def test_bracket_errors_are_translated(code):
    """It was half a sentence: ..., but the plate leaves 40 mm: lower it, ou make room."""
    said = set(recordings_refused(BRACKETS))
    assert len(said) > 40
    assert {s for s in said if ("error", s) not in message_catalogue(code)} == CALLED


BROKEN = (
    "title: [1", "title: {a", "title: x\n\ty: 1", "title: a: b", "title: 'x", "key\nother: 1",
    "a: @", "a: &x 1\nb: *y", "- a\nb: 1", "a:\n  - 1\n b: 2", "{", "[]]", "? [a]\n: 1", ": 1",
    "<<: 1", "a: !t 1", "\x00", "", "a: 1\n---\nb: 2", "a: - 1", "a: [1, 2", "a: {b: 1\nc: 2",
    "title: x\n  y: 1",
)  # fmt: skip
"""What somebody has typed so far."""


@pytest.mark.parametrize("code", OTHERS)
@pytest.mark.parametrize("text", BROKEN)
def test_yaml_syntax_errors_are_translated(code, text):
    """Whoever types is told in the middle of a line: in English, or "falta a value"."""
    with pytest.raises(InvalidFileError) as bad:
        reader.loads(text)
    english = words(
        "the this value comma line colon key missing closed check write quotes character indent "
        "indents first starts here list table put"
    )
    for problem in bad.value.problems:
        for said in filter(None, (problem.message, problem.hint)):
            assert not words(Translator(code).error(said)) & english


WORKBENCH = (
    "web/workspace.py",
    "web/revisions.py",
    "web/jobs.py",
    "web/session.py",
    "web/correction_handlers.py",
    "web/recording_handlers.py",
    "web/library.py",
    "web/limit_handlers.py",
    "web/upload.py",
    "web/bracket_handlers.py",
    "web/form_handlers.py",
    "application/limit_deviation.py",
    "application/form.py",
    "application/paste_import.py",
    "application/yaml_edit.py",
    "topics/design/drag_handles.py",
    "topics/torsion/launch_study.py",
    "topics/torsion/powertrain_model.py",
    "topics/torsion/study.py",
    "topics/torsion/operating_grid.py",
    "topics/torsion/vibration_checks.py",
    "model/application.py",
    "model/laminate.py",
    "model/parts.py",
    "model/powertrain.py",
    "model/vehicle.py",
    "physics/vehicle/*.py",
    "physics/strength/beams.py",
    "web/server.py",
    "cli/serve.py",
)
"""Where what a page shows is refused: its files, a hand's move, parts that cannot be."""


def met():
    """Sentences as somebody meets them, and what was named in them; a choice of words is one."""
    chosen = {
        "a deviation needs {0}": ("a reason", "who answers for it"),
        "shaft {0} of line {1} {2} centre bearing": ("carries no", "needs a"),
        "the {0} of a clutch's curve must rise": ("angles", "torques"),
    }
    for said in set(recordings_refused(WORKBENCH)) - {"{0} was changed on disk meanwhile"}:
        for word in chosen.get(said, ("7",)):
            named = ["7"] * said.count("{")
            if said in chosen:
                named[-1] = word
            yield said.format(*named)


@pytest.mark.slow
@pytest.mark.parametrize("code", OTHERS)
def test_workbench_errors_are_translated(code):
    """A joint that a hand brought to lock was told in English, and so was a folder it may not
    write in; 51 sentences were missing."""
    said = set(met())
    assert len(said) > 50
    say = Translator(code)
    assert sorted(one for one in said if say.error(one) == one) == []
    assert "Permission" not in say.error("Permission denied")


@pytest.mark.parametrize("code", OTHERS)
def test_variant_study_errors_are_translated(code):
    """What of the folder of its shards, of its workers and of what varies is refused."""
    modules = (
        "topics/variants/runner.py",
        "topics/variants/executors.py",
        "topics/variants/shard_job.py",
        "topics/variants/shard_store.py",
        "topics/variants/evaluation.py",
        "application/variant_sampling.py",
        "cli/study.py",
    )
    say, found = Translator(code), set(recordings_refused(modules))
    assert len(found) > 20
    for said in found:
        whole = f"{said}lost" if said.endswith(": ") else said
        whole = whole.replace("correlations {0}", "correlations contradict each other")
        whole = re.sub(r"{\d}", "7", whole)
        english = words("holds another shards folder goes varies without which contradict")
        assert not words(say.error(whole)) & english, whole
        assert say.error(whole) != whole


@pytest.mark.parametrize("code", OTHERS)
@pytest.mark.parametrize(("size", "degree", "volume"), [(1, 2, 1), (1, 3, 1), (1, 2, 1e-4)])
def test_bracket_model_size_error_is_translated(code, size, degree, volume):
    """An edge that would do is told; of a sheet of a tenth of a millimetre none would."""
    with pytest.raises(DesignError) as failed:
        check_affordable(
            ModelSize(volume=1e-2 * volume, area=2.0, element_size=size * mm, degree=degree)
        )
    told = Translator(code).error(f"a.yaml:3: bracket: original bracket: {failed.value}")
    assert {"elements", "allowed", "million"} < words(str(failed.value))
    english = "elements degree would allowed are about million unknowns minutes try lower check"
    assert not words(told) & words(f"{english} sheet asks bends whatever thickness")


@pytest.mark.parametrize("code", OTHERS)
def test_alternative_clause_of_error_is_translated(code):
    """It was found by "{0} or {1}", and half of it stayed English: too short ou has holes."""
    told = Translator(code).error("run.csv: its time column is too short or has holes")
    assert told.startswith("run.csv: ")
    assert not {"too", "short", "holes"} & set(re.findall("[a-z]+", told))


@pytest.mark.parametrize("code", OTHERS)
def test_campaign_schema_rules_are_translated_completely(code):
    """It was "uma lista de tables with file, ...", and "falta cycles: at the knee"."""
    tables = (
        SegmentTable,
        AdditionalRecordingFileTable,
        CampaignRecordingTable,
        ChannelTable,
        GaugeFatigueStrengthTable,
        CampaignTable,
    )
    say = Translator(code)
    for table in tables:
        rule = TableField(table)
        for many in (
            ListField(rule).singular,
            MappingField(TextField(), rule).singular,
            MappingField(TextField(), rule).plural,
        ):
            assert not words(say.error(many)) & {"tables", "with", "names", "lists"}
        needed = [e.description for e in table.entries().values() if e.required]
        assert [n for n in needed if ("error", n) not in message_catalogue(code)] == []


def tables(of=Table):
    """Every table that a file may have."""
    for one in of.__subclasses__():
        yield one
        yield from tables(one)


@pytest.mark.parametrize("code", OTHERS)
def test_missing_key_descriptions_are_translated_completely(code):
    """It was "falta wheelbase_mm: front axle (or the middle of two) to rear axle or bogie"."""
    for module in pkgutil.walk_packages(cardan.__path__, "cardan."):
        if module.name.startswith(("cardan.application.", "cardan.topics.")):
            importlib.import_module(module.name)
    ours = [t for t in tables() if t.__module__.startswith("cardan.")]
    needed = {e.description for t in ours for e in t.entries().values() if e.required}
    assert len(needed) > 70
    assert sorted(n for n in needed if ("error", n) not in message_catalogue(code)) == []
    say = Translator(code)
    whole = {n: say.error(f"length_mm or length_m is missing: {n}") for n in needed}
    assert {n: told for n, told in whole.items() if n in told} == {}


@pytest.mark.parametrize(
    ("code", "refused", "said"),
    [
        ("pt", "unknown key", "chave desconhecida"),
        ("it", "did you mean torque_Nm?", "si intendeva torque_Nm?"),
        ("pt", "must be a number of 0 or more", "deve ser um número de 0 ou mais"),
        ("it", "no catalogue has a tube 100x33", "nessun catalogo ha un tubo 100x33"),
        ("pt", "x holds another study, with other application, limits: name another folder",
         "x contém outro estudo, que difere em aplicação, limites: indique outra pasta"),
        ("it", "vary, tolerances or ask, files that it names changed while the study ran: begin it"
         " anew", "mentre lo studio era in corso è cambiato: vary, tolerances o ask, file che "
         "indica; ricominciarlo"),
        ("pt", "nobody, ever, refused this", "nobody, ever, refused this"),
        ("en", "unknown key", "unknown key"),
    ],
)  # fmt: skip
def test_error_is_translated_by_its_pattern(code, refused, said):
    assert Translator(code).error(refused) == said


def test_bad_file_error_uses_language_option(tmp_path):
    file = tmp_path / "t.yaml"
    file.write_text("title: x\nsped_rpm: 2,5\n", encoding="utf-8")
    result = CliRunner().invoke(cli, ["check", str(file), "--lang", "pt"])
    assert result.exit_code == 2
    assert f"erro: {file}:2:1: sped_rpm: chave desconhecida; quis dizer speed_rpm?" in result.output


def test_input_warning_uses_language_option(tmp_path):
    file = tmp_path / "t.yaml"
    text = templates.template_text("small").replace(
        "outer_mm: 101.6, wall_mm: 3.2", "outer_mm: 101.6, wall_mm: 30"
    )
    file.write_text(text, encoding="utf-8")
    result = CliRunner().invoke(cli, ["check", str(file), "--lang", "it", "--quiet"])
    assert "avviso: " in result.output
    assert "insolitamente grande" in result.output


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("check --lang it --foo x.yaml",
         "errore: opzione sconosciuta: '--foo'; si intendeva '--pdf'?; vedere cli check --help"),
        ("joint --angle 4.5deg --lang=pt",
         "erro: falta a opção '--speed'; veja cli joint --help"),
        ("joint --lang pt --angle x --speed 3600rpm",
         "erro: valor inválido de '--angle': deve ser um número com sua unidade, como 4.5deg "
         "(veio x); veja cli joint --help"),
        ("fix x.yaml --count 0 --lang it",
         "errore: valore non valido di '--count': 0 non è nell'intervallo x>=1; "
         "vedere cli fix --help"),
        ("catalogue nonsense --lang pt", "erro: não há catálogo de nonsense; há: joints, "),
        ("explain nonsense --lang it", "errore: non c'è grandezza nonsense ("),
        ("joint --angle 4.5deg", "error: Missing option '--speed'; see cli joint --help"),
    ],
)  # fmt: skip
def test_option_error_uses_language_option(line, said):
    result = CliRunner().invoke(cli, line.split())
    assert result.exit_code == 2
    assert said in result.output


def told_of_a_bracket():
    """What a bracket's solution says of how far it is."""
    for path in (
        (ROOT / "src/cardan").glob(g) for g in ("physics/fem/*.py", "topics/bracket/*.py")
    ):
        for one in path:
            for node in ast.walk(ast.parse(one.read_text(encoding="utf-8"))):
                match node:
                    case ast.Call(func=ast.Name("tell" | "told"), args=[value]):
                        yield from written(value)
                    case _:
                        pass


@pytest.mark.slow
@pytest.mark.parametrize("code", OTHERS)
def test_bracket_progress_messages_are_translated(code):
    """Minutes of English stood on a page in Italian."""
    said = {s for s in told_of_a_bracket() if re.sub(r"\{\d\}|\W", "", s)}
    assert len(said) > 10
    assert sorted(s for s in said if ("error", s) not in message_catalogue(code)) == []
    meshing = Translator(code).error("reinforced: meshing")
    assert not words(meshing) & {"reinforced", "meshing"}
    assert "{" not in Translator(code).error("a: assembling 3000 unknowns, 20 elements")
