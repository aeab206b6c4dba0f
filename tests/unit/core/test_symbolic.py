"""Functions of the physics run on symbols: what is printed is what arrays compute.

A printed formula is read back, by the rules of whoever reads it, and must come to the number
that the function comes to. LibreOffice reads whole workbooks in tests/office.
"""

import math
import re

import numpy as np
import pytest
from hypothesis import assume, given, reject
from hypothesis import strategies as st

from cardan.application import reader, templates
from cardan.approval.approval import approve_driveline
from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.symbolic import (
    ConstantWithDisplayText,
    Expression,
    complex_symbols,
    symbols,
    trace_expression,
)
from cardan.core.units import MPa, deg, hour, rpm
from cardan.physics.kinematics.equivalent_angle import (
    ae7_acceleration,
    ae7_equivalent_angle,
    ae7_phasor_term,
    ae7_sign_of_next_joint,
)
from cardan.physics.loads.small_angle import (
    bearing_force,
    residual_angles,
    shaft_end_force_of_couple,
)
from cardan.physics.strength.bearing_life import cross_joint_life_consumption_rate, joint_life
from cardan.physics.strength.critical_speed import slender_tube_critical_speed
from cardan.physics.strength.torsional_strength import tube_utilisation

FORMULAS = [q for q in QUANTITIES.values() if isinstance(q.equation, Expression)]
RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹", "0123456789")


class Text:
    """Plain text as a reader of formulas takes it: what stands side by side is multiplied first."""

    def __init__(self, text, **values):
        found = r"[\d.]+·10[⁰¹²³⁴-⁹]+|[\d.]+|[⁰¹²³⁴-⁹]+|[^\W\d⁰¹²³⁴-⁹][^\W⁰¹²³⁴-⁹]*|[-+−/^()|,√*]"
        self.left, self.values = re.findall(found, text.replace("°", "")), values | {"π": math.pi}
        self.inside = False  # between the strokes of a size

    def next(self, *wanted):
        return bool(self.left) and self.left[0] in wanted and self.left.pop(0)

    def sum(self):
        value = -self.quotient() if self.next("−") else self.quotient()
        while sign := self.next("+", "−"):
            value += self.quotient() * (1 if sign == "+" else -1)
        return value

    def quotient(self):
        value = self.product()
        return value / self.product() if self.next("/") else value

    def product(self):
        value = self.power()
        while self.left and self.left[0] not in "+−/),|"[: 5 + self.inside]:
            value *= self.power()
        return value

    def power(self):
        value = self.atom()
        if self.left and self.left[0][0] in "⁰¹²³⁴⁵⁶⁷⁸⁹":
            return value ** int(self.left.pop(0).translate(RAISED))
        return value ** self.atom() if self.next("^") else value

    def atom(self):
        if self.next("√"):
            return math.sqrt(self.atom())
        if self.next("("):
            value = self.sum()
            assert self.next(")")
            return value
        if self.next("|"):
            self.inside = True
            value = abs(self.sum())
            assert self.next("|")
            self.inside = False
            return value
        word = self.left.pop(0)
        if word == "max":
            assert self.next("(")
            both = self.sum(), self.next(",") and self.sum()
            assert self.next(")")
            return max(both)
        if "·" in word:
            front, power = word.split("·10")
            return float(front) * 10 ** int(power.translate(RAISED))
        return float(word) if word[0].isdigit() else self.values[word]


def computed(printed, **cells):
    """What a spreadsheet makes of a formula: no sign before, and no power of, a bare power."""
    assert not re.search(r"(^|[-+*/^,(])-[\w.]+(\([^()]*\))?\^|\^[\w.]+\^", printed)
    known = {"SQRT": math.sqrt, "ABS": abs, "COS": math.cos, "SIN": math.sin, "PI": lambda: math.pi}
    return eval(printed.replace("^", "**"), {"__builtins__": {}}, known | cells)


# --------------------------------------------------------------------------- any formula


REALS, COMPLEX = ("a", "b", "c"), ("P", "Q")


def grown(leaf):
    two = st.sampled_from(["+", "-", "*", "/"])
    return st.one_of(
        st.tuples(two, leaf, leaf),
        st.tuples(st.sampled_from(["neg", "square", "abs"]), leaf),
    )


REAL_TREES = st.recursive(st.sampled_from([*REALS, 1, 2, -0.5, 10 / 3]), grown, max_leaves=9)
TREES = st.recursive(st.sampled_from([*REALS, *COMPLEX, 2, 1j]), lambda leaf: st.one_of(
    st.tuples(st.sampled_from(["+", "-", "*"]), leaf, leaf),
    st.tuples(st.sampled_from(["neg", "square", "conj"]), leaf),
    st.tuples(st.just("abs"), leaf), st.tuples(st.just("turn"), REAL_TREES),
), max_leaves=8)  # fmt: skip


def run(tree, known):
    """Compute a tree with whatever the names stand for: numbers, or symbols."""
    if not isinstance(tree, tuple):
        return known[tree] if isinstance(tree, str) else tree
    head, *of = tree
    a, *b = (run(one, known) for one in of)
    if head == "turn":
        exp = a.__array_namespace__().exp if isinstance(a, Expression) else np.exp
        return exp(1j * a)
    return {
        "+": lambda: a + b[0], "-": lambda: a - b[0], "*": lambda: a * b[0],
        "/": lambda: a / b[0], "neg": lambda: -a, "square": lambda: a**2, "abs": lambda: abs(a),
        "conj": lambda: a.conj() if isinstance(a, Expression) else np.conj(a),
    }[head]()  # fmt: skip


KNOWN = dict(zip((*REALS, *COMPLEX), (1.7, -0.6, 2.3, 0.4 - 1.2j, -0.9 + 0.7j), strict=True))
NAMES = dict(zip((*REALS, *COMPLEX), (*symbols(*REALS), *complex_symbols(*COMPLEX)), strict=True))


def worth(tree, known):
    """The value of a tree, where every step to it is a number that others can compute too."""
    try:
        with np.errstate(all="raise"):
            value, made = (
                run(tree, {k: np.complex128(v) for k, v in known.items()}),
                run(tree, NAMES),
            )
    except (ZeroDivisionError, FloatingPointError, OverflowError):
        reject()
    assume(isinstance(made, Expression))
    assume(value == 0 or 1e-9 < abs(value) < 1e9)
    return complex(value), made


@pytest.mark.slow
@given(REAL_TREES)
def test_text_and_cells_of_any_formula_come_to_its_value(tree):
    reals = {k: KNOWN[k] for k in REALS}
    value, made = worth(tree, reals)
    close = pytest.approx(value.real, rel=1e-9, abs=1e-9)
    assert computed(made.to_spreadsheet(a="a", b="b", c="c"), **reals) == close
    # A cell may hold a formula, and a negative number one of its own.
    assert computed(made.to_spreadsheet(a="3.7-2", b="-0.6", c="4.6/2")) == close
    assume(str(tree).count("abs") < 2)  # strokes within strokes are read by nobody
    reader = Text(str(made), **reals)
    assert reader.sum() == pytest.approx(value.real, rel=1e-6, abs=1e-6)  # twelve digits
    assert reader.left == []


@pytest.mark.slow
@given(TREES)
def test_a_complex_formula_comes_apart_into_what_its_value_does(tree):
    value, made = worth(tree, KNOWN)
    held = {"P": ("Pr", "Pi"), "Q": ("Qr", "Qi")}
    cells = {k: KNOWN[k] for k in REALS}
    for name, (re_, im_) in held.items():
        cells |= {re_: KNOWN[name].real, im_: KNOWN[name].imag}
    found = [computed(of, **cells) for of in made.to_spreadsheet_pair(a="a", b="b", c="c", **held)]
    assert complex(*found) == pytest.approx(value, rel=1e-9, abs=1e-9)


# --------------------------------------------------------------------------- the program's own


VALUES = {
    "Tm": 950.0, "i": 5.3, "η": 0.93, "k": 1.8, "s": 0.5, "μ": 0.8, "N": 9.1e4, "re": 0.48,
    "iD": 4.88, "ηD": 0.96, "βv": 0.03, "βh": -0.02, "ω": 120.0, "β": 4.2, "L": 1.4, "D": 0.12,
    "d": 0.112, "E": 206e9, "ρ": 7850.0, "n": 1450.0, "nc": 5200.0, "T": -3100.0, "K": 1.4,
    "Re": 355e6, "Td": 2900.0, "K1": 1.25, "F": 2.1e4, "l": 0.04, "M": 240.0, "w": 0.14,
}  # fmt: skip


@pytest.mark.parametrize("q", FORMULAS, ids=lambda q: q.key)
def test_text_and_cells_of_a_quantity_come_to_the_same(q):
    of = {
        k: v for k, v in VALUES.items() if re.search(rf"(?<!\w){k}(?![^\W⁰¹²³⁴-⁹])", str(q.formula))
    }
    reader = Text(str(q.formula), **of)
    value = reader.sum()
    assert reader.left == []
    assert computed(q.formula.to_spreadsheet(**{k: k for k in of}), **of) == pytest.approx(
        value, rel=1e-12
    )
    for symbol in re.findall(r"[^\W\d⁰¹²³⁴-⁹][^\W⁰¹²³⁴-⁹]*", str(q.formula)):
        said = {s for group in q.symbol_meanings for s in group.split(", ")}
        assert symbol in said | {"π", "max"} or symbol in {"T", "n", "nc", "ω", "β"}, symbol


def test_they_are_in_the_units_they_are_printed_in():
    """The functions compute in SI; a formula of hours, rpm and degrees comes to the same."""
    v = VALUES
    tube = {"outer": v["D"], "inner": v["d"]}
    found = slender_tube_critical_speed(v["L"], **tube, youngs_modulus=v["E"], density=v["ρ"]) / rpm
    assert Text(str(QUANTITIES["critical_speed"].formula), **v).sum() == pytest.approx(found)
    used = cross_joint_life_consumption_rate(
        v["T"],
        speed=v["n"] * rpm,
        angle=v["β"] * deg,
        rated_torque=v["Td"],
        prime_mover_factor=v["K1"],
    )
    hours = joint_life(used) / hour
    assert Text(str(QUANTITIES["joint_life"].formula), **v).sum() == pytest.approx(hours, rel=1e-12)
    still = v | {"β": 1.0}  # needles that hardly rock
    floor = Text(str(QUANTITIES["joint_life"].formula), **still).sum()
    assert floor == pytest.approx(hours * 4.2 / 3, rel=1e-12)
    share = tube_utilisation(v["T"], **tube, yield_strength=355 * MPa, shock_factor=1.4)
    text = str(QUANTITIES["tube_shear_utilisation"].formula)
    assert Text(text, **v).sum() == pytest.approx(share, rel=1e-12)


def test_the_engine_s_torque_is_that_of_the_gears():
    """Its formula stands beside the code that goes through all gears: the lowest is strongest."""
    application = reader.loads(templates.template_text("truck").replace(
        "converter_ratio: 1.0", "converter_ratio: 1.7").replace(
        "transfer_ratio: 1.0 ", "transfer_ratio: 1.3 "))  # fmt: skip
    (r,) = approve_driveline(application).line_responses
    gearbox, text = application.gearbox, str(QUANTITIES["engine_torque"].formula)
    found = Text(text, Tm=950.0, i=9.2 * 1.3, η=gearbox.efficiency, k=1.7, s=1.0).sum()
    assert r.demand.engine_torque == pytest.approx(found)


def test_formulas_read_as_in_a_book():
    said = {q.key: q.equation_text for q in FORMULAS}
    assert said["critical_speed"] == "nc = (30/π) (π / L)² √(E (D² + d²) / (16 ρ))"
    assert said["joint_life"] == "Lh = 1.5·10⁶ / (K1 |n| max(β, 3°) (|T| / Td)^(10/3))"
    assert said["tube_shear_utilisation"] == "16 |T| K D √3 / (π (D⁴ − d⁴) Re)"
    assert said["slip_torque"] == "Ts = μ N re / (iD ηD)"
    assert said["angle_for_speed"] == "ω² β²"


def test_ae7_and_small_angles_read_as_in_a_book():
    (s, P, D, F), (e, w) = complex_symbols("s", "P", "D", "F"), symbols("ε", "ω")
    h, v = symbols("βh", "βv")
    assert str(ae7_sign_of_next_joint(s, phase=e)) == "−s e^(2i ε)"
    assert str(P + ae7_phasor_term(s, side=v, top=h)) == "P + s (βh + i βv)²"
    assert str(ae7_equivalent_angle(P)) == "√|P|"
    assert str(ae7_acceleration([P, D], speed=w)) == "ω² |P + D|"
    mean, swing = residual_angles(D, F, signs=(s, P))
    T, L = symbols("T", "L")
    assert str(shaft_end_force_of_couple(mean, torque=T, length=L)) == "0.5i T (D + F) / L"
    assert str(shaft_end_force_of_couple(swing, torque=T, length=L)) == "0.5i T (s D* − P F*) / L"
    held = bearing_force(P, beyond=F, length=L, overhang=e)
    assert str(held) == "L (P − F) / (L − ε)"


def test_formulas_are_set_for_pages():
    latex = {q.key: q.formula.latex for q in FORMULAS}
    assert latex["slip_torque"] == r"\frac{μ \, N \, r_{e}}{i_{D} \, η_{D}}"
    assert latex["compound_angle"] == r"\sqrt{β_{v}^{2} + β_{h}^{2}}"
    assert r"\frac{1.5 \cdot 10^{6}}{K_{1} \, \lvert n \rvert" in latex["joint_life"]
    assert r"\left(\frac{π}{L}\right)^{2}" in latex["critical_speed"]
    assert r"D \, \sqrt{3}}" in latex["tube_shear_utilisation"]
    assert not any("|" in of for of in latex.values())  # which would end a table's cell


def test_a_constant_counts_as_a_number_and_prints_as_it_is_written():
    third = ConstantWithDisplayText(1 / 3, "⅓", "1/3")
    assert third * np.array([3.0]) == [1.0]
    (of,) = symbols("a")
    assert str(third * of) == "⅓ a"
    assert (of / third).to_spreadsheet(a="A1") == "A1/(1/3)"


def test_what_no_two_cells_hold_is_refused():
    """Better no formula than half of one."""
    P, Q = complex_symbols("P", "Q")
    (xp,) = {P.__array_namespace__(), Q.__array_namespace__()}
    for of in (P / Q, P**3, xp.sqrt(P), xp.exp(P), 2**P):
        with pytest.raises(ValueError, match="in two cells"):
            of.to_spreadsheet_pair(P=("A1", "B1"), Q=("C1", "D1"))


def test_what_is_asked_for_and_not_there_is_named():
    with pytest.raises(KeyError, match="nc"):
        trace_expression(lambda n, nc: n / nc, "n", "nc").to_spreadsheet(n="A1")
