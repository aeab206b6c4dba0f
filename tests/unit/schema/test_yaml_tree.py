"""YAML as a tree with places, and its traps."""

# ruff: noqa: E501  messages stand here as they are printed

import pytest
import yaml

from cardan.application.reader import loads
from cardan.application.templates import template_text
from cardan.core.errors import InvalidFileError
from cardan.schema.yaml_tree import (
    MAX_FILE_CHARACTERS,
    MAX_NESTING_DEPTH,
    Mapping,
    Scalar,
    Sequence,
    parse_number,
    parse_yaml,
    read_text,
)


def tree(text):
    root, problems = parse_yaml(text, "f.yaml")
    assert not problems
    return root


def refused(text):
    with pytest.raises(InvalidFileError) as error:
        parse_yaml(text, "f.yaml")
    return str(error.value)


def test_every_key_and_value_knows_its_place():
    root = tree("a: 1\nb:\n  - {c: x, dé: [10, 2.5]}\n")
    key, value = root.entries["a"]
    assert (key.line, key.column, value.line, value.column) == (1, 1, 1, 4)
    inner = root.entries["b"][1].items[0]
    assert (inner.line, inner.column) == (3, 5)
    key, value = inner.entries["dé"]
    assert (key.line, key.column, value.line, value.column) == (3, 12, 3, 16)
    assert [(i.line, i.column) for i in value.items] == [(3, 17), (3, 21)]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("12", 12), ("-3", -3), ("+3", 3), ("2.50", 2.5), (".5", 0.5), ("5.", 5.0),
        ("1e3", 1000.0), ("-1.5E-2", -0.015), ("0", 0), ("0.12", 0.12), ("-0.5", -0.5),
        ("true", True), ("FALSE", False), ("~", None), ("null", None), ("", None),
        # What YAML 1.1 takes for something else is a text.
        ("no", "no"), ("yes", "yes"), ("on", "on"), ("Off", "Off"), ("y", "y"),
        ("1:30", "1:30"), ("010", "010"), ("0x1F", "0x1F"), ("1_000", "1_000"),
        ("2,7", "2,7"), ("1 800", "1 800"), (".inf", ".inf"), (".nan", ".nan"), ("nan", "nan"),
        ("2026-11-20", "2026-11-20"), ("6x2", "6x2"), ("687.40", 687.4), ("=", "="),
    ],
)  # fmt: skip
def test_a_word_means_what_a_reader_expects(text, value):
    found = tree(f"a: {text}").value["a"]
    assert found == value
    assert type(found) is type(value)


def test_quotes_make_a_text_of_anything():
    assert tree("{a: '12', b: \"true\", c: ''}").value == {"a": "12", "b": "true", "c": ""}


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("2,7", "write a decimal point: 2.7"),
        ("-2,75", "write a decimal point: -2.75"),
        ("1,800", "thousands or decimals? write a point before decimals and nothing between "
         "thousands"),
        ("1 800", "write the digits without anything between them"),
        ("1'800", "write the digits without anything between them"),
        ("1_800.5", "write the digits without anything between them"),
        ("1\u202f800", "write the digits without anything between them"),
        ("1:30", "some readers take a colon as minutes: write one decimal number"),
        ("010", "some readers take a leading 0 as octal: write 10"),
        ("-007.5", "some readers take a leading 0 as octal: write -7.5"),
        ("nan", "it must be finite"), (".NaN", "it must be finite"), ("-.inf", "it must be finite"),
        ("Infinity", "it must be finite"),
        ("0x1F", "write it in decimal digits"), ("0o17", "write it in decimal digits"),
        ("\u22122.7", "the minus sign is a dash: write -2.7"),
        ("1200 mm", "write the number alone"), ("4\u00b0", "write the number alone"),
        ("four", ""), ("", ""), ("1.2.3", ""), ("--4", ""), ("true", ""),
    ],
)  # fmt: skip
def test_what_is_no_number_says_how_to_write_one(text, hint):
    assert parse_number(Scalar(text, 1, 1)) == (None, hint)


def test_a_number_in_quotes_is_no_number():
    assert parse_number(Scalar("12", 1, 1, quoted=True)) == (
        None,
        "a text in quotes is no number: write 12",
    )


@pytest.mark.parametrize("digit", ["9", "0", "1,", "1_", "1:"])
def test_a_number_of_a_million_digits_is_refused_without_thinking(digit):
    assert parse_number(Scalar(digit * 1_000_000, 1, 1)) == (None, "")
    assert parse_number(Scalar("9" * 60, 1, 1))[0] == pytest.approx(1e60)


def test_a_key_given_twice_is_a_problem_that_names_both_lines():
    root, problems = parse_yaml("a: 1\nb:\n  c: 1\n  c: 2\na: 3\n", "f.yaml")
    assert [p.format_with_location("f.yaml") for p in problems] == [
        "f.yaml:4:3: c: given twice, first in line 3; keep one",
        "f.yaml:5:1: a: given twice, first in line 1; keep one",
    ]
    assert root.value == {"a": 1, "b": {"c": 1}}


@pytest.mark.parametrize("text", ["[2,7, 3.5]", "[3,0, 1,0]", "[1,5, 2]", "[-2,7, 0]"])
def test_a_decimal_comma_in_a_list_is_noticed(text):
    _, problems = parse_yaml(f"a: {text}", "f.yaml")
    assert "is one a decimal comma?" in problems[0].message
    assert problems[0].line == 1


@pytest.mark.parametrize("text", ["[2, 7]", "[2,7]", "[2 ,7 ]", "[0,0,0]", "[a,b, c]", "[1,-2, 3]"])
def test_a_list_written_in_one_way_is_just_a_list(text):
    assert len(tree(f"a: {text}").value["a"]) == text.count(",") + 1


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "f.yaml:1:1: the file is empty; `cardan new` writes one to start from"),
        ("# only words\n", "f.yaml:1:1: the file is empty; `cardan new` writes one to start from"),
        ("a: 1\n---\nb: 2\n", "f.yaml:2:1: a second document starts here; one file holds one"),
        ("a:\n\tb: 1\n", "f.yaml:2:1: a tab indents this line (got b: 1); YAML indents with spaces"),
        ("a: !!float 1", "f.yaml:1:4: tags like tag:yaml.org,2002:float are not used; remove it"),
        ("a: !x {b: 1}", "f.yaml:1:4: tags like !x are not used; remove it"),
        ("a: *b", "f.yaml:1:4: *b stands for nothing above it; name it first with &b"),
        ("a: &b [*b]", "f.yaml:1:8: *b stands for nothing above it; name it first with &b"),
        ("? [1, 2]\n: 3", "f.yaml:1:3: a key must be a word; is this list or table a value?"),
        ("a: {<<: {b: 1}}", "f.yaml:1:5: merging tables with << is not part of YAML 1.2; write "
         "the keys out, or refer to a whole table with *name"),
        ("? \n: 1", "f.yaml:1:2: a key is missing before the colon"),
        ("a: [1, 2\nb: 3\n", "f.yaml:2:2: a list is not closed, or a comma is missing, opened in "
         "line 1 (got b: 3); check [ and ]"),
        ("a: {b: 1\nc: 3\n", "f.yaml:2:2: a table is not closed, or a comma is missing, opened in "
         "line 1 (got c: 3); check { and }"),
        ("a: 'b\nc: 3\n", "f.yaml:1:4: a quote is opened and never closed (got a: 'b); check "
         "quotes"),
        ("a:1\nb: 2\n", "f.yaml:2:2: a second colon makes no sense here (got b: 2); is the line "
         "above indented like this one, with a space after its colon? put a text that holds ': ' "
         "in quotes"),
        ("a: 1\nb:2\nc: 3\n", "f.yaml:2:1: a key without its colon (got b:2); write `key: value`, "
         "with a space after the colon"),
        ("a:\n  b: 1\n c: 2\n", "f.yaml:3:2: this line does not fit the lines above it (got c: 2); "
         "indent keys of one table alike, and close quotes and brackets"),
        ("a: @b", "f.yaml:1:4: this character cannot start a value (got a: @b); put the text in "
         "quotes"),
        ("a: b\x07", "f.yaml:1:5: a control character (U+0007) stands here; is this a text file? "
         "save it as UTF-8"),
        ("a: 1\nb: \x00", "f.yaml:2:4: a control character (U+0000) stands here; is this a text "
         "file? save it as UTF-8"),
    ],
)  # fmt: skip
def test_what_is_no_yaml_is_explained(text, message):
    assert refused(text) == message


HIDDEN = {
    r"\e": "a control character (U+001B)",
    r"\0": "a control character (U+0000)",
    r"\r": "a control character (U+000D)",
    r"\x9b": "a control character (U+009B)",
    r"\L": "line separator (U+2028)",
    r"\ufffe": "a code of no character (U+FFFE)",
    r"\U0001fffe": "a code of no character (U+1FFFE)",
    r"\u200e": "left-to-right mark (U+200E)",
    r"\u202a": "left-to-right embedding (U+202A)",
    r"\u202e": "right-to-left override (U+202E)",
    r"\u2066": "left-to-right isolate (U+2066)",
    r"\u2069": "pop directional isolate (U+2069)",
}


@pytest.mark.parametrize("escape", HIDDEN)
def test_what_an_escape_hides_is_named_where_it_stands(escape):
    """`"\\e]0;..."` renamed terminals and U+202E turned names round: both passed unseen."""
    said = f"{HIDDEN[escape]} is in this text; it can make a text look like another: remove it"
    assert refused(f'a: 1\nb: "x{escape}y"\n') == f"f.yaml:2:4: {said}"
    assert refused(f'a: 1\n"x{escape}y": 1\n') == f"f.yaml:2:1: {said}"


@pytest.mark.parametrize("character", "\u061c\u200e\u200f\u202a\u202e\u2066\u2069")
def test_what_turns_a_text_round_is_refused_as_it_stands(character):
    said = refused(f"a: 1 # x{character}y\n")
    assert said.startswith("f.yaml:1:9: ")
    assert f"(U+{ord(character):04X}) stands here; it can make a text look like another" in said


def test_accents_and_emoji_may_stay():
    """What joins emoji is not seen by itself, and is refused."""
    written = "Caminha\u0303o 卡车 🔧"
    escaped = written.replace("\u0303", r"\u0303")
    assert tree(f'a: "{escaped}"\nb: {written}\n').value == {"a": written, "b": written}


def test_a_tag_cannot_reach_a_terminal():
    """Tags are written with % escapes, which libyaml decodes: one held an escape sequence."""
    assert "\x1b" not in refused("a: !<%1b]0;x> 1\n")


def test_a_reference_stands_for_what_it_names():
    assert tree("a: &t {b: 1}\nc: [*t, *t]\n").value == {"a": {"b": 1}, "c": [{"b": 1}] * 2}


def test_references_cannot_blow_up():
    """Ten to the ninth leaves in ten lines, the billion laughs: refused before it grows."""
    lines = ["a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]"]
    lines += [f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 10)}]" for k in range(1, 9)]
    assert "with its references written out the file has over" in refused("\n".join(lines))


@pytest.mark.slow
def test_what_a_reference_holds_is_counted_to_its_bottom():
    """A table of 100 rows of 1000 numbers is 100 101 entries: written once it may be, not twice."""
    table = ", ".join(["[" + ", ".join(["1"] * 1000) + "]"] * 100)
    assert tree(f"a: &a [{table}]\n")
    said = refused(f"a: &a [{table}]\nb: *a\n")
    assert "with its references written out the file has over 200000 entries" in said


def test_nesting_has_a_bottom():
    assert tree("[" * MAX_NESTING_DEPTH + "]" * MAX_NESTING_DEPTH)
    assert f"may be nested {MAX_NESTING_DEPTH} deep" in refused(
        "[" * (MAX_NESTING_DEPTH + 1) + "]" * (MAX_NESTING_DEPTH + 1)
    )
    assert f"may be nested {MAX_NESTING_DEPTH} deep" in refused("[" * 500_000)


def test_a_file_of_megabytes_is_taken_for_a_recording(tmp_path):
    assert refused("#" * (MAX_FILE_CHARACTERS + 1)).endswith("; is it a recording?")
    long = tmp_path / "long.yaml"
    long.write_bytes(b"#" * (4 * MAX_FILE_CHARACTERS + 1))
    with pytest.raises(InvalidFileError, match="this has 8 MB; is it a recording"):
        read_text(long)


def test_a_file_that_is_not_there_has_neighbours(tmp_path):
    (tmp_path / "truck.yaml").touch()
    with pytest.raises(InvalidFileError) as error:
        read_text(tmp_path / "trucks.yaml")
    name = tmp_path / "trucks.yaml"
    assert str(error.value) == (
        f"{name}: cannot be read: No such file or directory; "
        f"did you mean {tmp_path / 'truck.yaml'}?"
    )
    with pytest.raises(InvalidFileError, match="there is no folder"):
        read_text(tmp_path / "nowhere" / "truck.yaml")
    with pytest.raises(InvalidFileError, match="this is no file"):
        read_text(tmp_path)
    with pytest.raises(InvalidFileError, match=r"cannot be read: .*embedded null (byte|character)"):
        read_text(tmp_path / "a\0b.yaml")


def test_another_encoding_is_named_with_its_place(tmp_path):
    latin = tmp_path / "latin.yaml"
    latin.write_bytes("a: 1\ntitle: Caminhão\n".encode("latin-1"))
    with pytest.raises(InvalidFileError) as error:
        read_text(latin)
    assert str(error.value) == (
        f"{latin}:2:14: byte 0xe3 is no UTF-8; save the file with the encoding UTF-8"
    )


def test_marks_of_windows_and_accents_do_no_harm(tmp_path):
    file = tmp_path / "windows.yaml"
    file.write_bytes("\ufefftitle: Caminhão\r\nb: 2\r\n".encode())
    assert read_text(file).startswith("title")
    assert tree(read_text(file)).value == {"title": "Caminhão", "b": 2}


def test_nodes_say_briefly_what_they_are():
    assert Scalar("x" * 60, 1, 1).shortened_text == "x" * 37 + "..."
    assert Scalar("12", 1, 1, quoted=True).shortened_text == "'12'"
    assert Scalar("", 1, 1).shortened_text == "nothing"
    assert [Sequence(1, 1).shortened_text, Mapping(1, 1).shortened_text] == [
        "an empty list",
        "an empty table",
    ]
    assert [tree("[1, 2]").shortened_text, tree("{a: 1}").shortened_text] == [
        "a list of 2",
        "a table",
    ]


@pytest.mark.parametrize(
    "character",
    "\xad\u034f\u115f\u17b4\u180b\u180e\u200b\u200c\u200d\u2060\u2064\u206f\u3164\ufe00\ufe0f\ufeff"
    "\uffa0\ufff9\ufffb\U0001d173\U000e0001\U000e0100",
)
def test_what_nobody_sees_is_refused_in_a_name(character):
    """Two obstacles named "beam" stood side by side, one with a soft hyphen in it."""
    for text in (f"title: be{character}am\n", f'title: "be\\U{ord(character):08x}am"\n'):
        with pytest.raises(
            InvalidFileError, match=rf"\(U\+{ord(character):04X}\).*look like another"
        ):
            loads(text + "driveline: {}\n")


def test_accents_stay_and_names_are_one_where_they_print_as_one():
    """A combining accent is seen; written so or as one character, a name is the same."""
    small = yaml.safe_load(template_text("small"))
    ball = {"start_mm": [500, 0, -300], "radius_mm": 10}
    apart, together = "eixo auxiliar \u0301e", "cafe\u0301"
    beside = [{"name": n, **ball} for n in (apart, together)]
    assert (
        len(loads(yaml.safe_dump(small | {"obstacles": beside}, allow_unicode=True)).obstacles) == 2
    )
    alike = [{"name": n, **ball} for n in ("caf\xe9", "cafe\u0301")]
    with pytest.raises(InvalidFileError, match="this name is above already"):
        loads(yaml.safe_dump(small | {"obstacles": alike}, allow_unicode=True))
