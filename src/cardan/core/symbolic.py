"""What a function computes, written out: the same lines that arrays run through, as a formula.

A symbol is an array of a library of its own. A function of the physics that computes with
operators and with what `array_library_and_floats` gives it takes symbols for numbers, and what
comes back is the formula that it is:

    of = trace_expression(slender_tube_critical_speed, "L", outer="D", inner="d",
                          youngs_modulus="E", density="ρ")

    str(of)                         (π / L)² √(E (D² + d²) / (16 ρ))
    of.latex                        the same for pages that set mathematics
    of.to_spreadsheet(L="B4/1000", ...)      the same for a spreadsheet, of the cells that hold them

So no equation is written next to the code that computes it. Complex numbers are taken apart
for a spreadsheet, which holds one in two cells: `to_spreadsheet_pair`.
"""

import math
import re
from collections.abc import Callable
from typing import Any, ClassVar, Self, TypeAlias

from cardan.core.lazy_dataclass import dataclass

CellReference: TypeAlias = str | tuple[str, str]
"""What holds a symbol in a spreadsheet, cell or formula; of a phasor real and imaginary part."""


class ConstantWithDisplayText(float):
    """A number that prints as people write it: `text` in texts, `spreadsheet_text` in spreadsheets.

    Both are in the units of the printed formula where those are not SI, like a factor 1.5·10⁶
    between hours, rpm and degrees; arrays compute with its value as with any number.
    """

    text: str
    spreadsheet_text: str

    def __new__(cls, value: float, shown: str, cell: str) -> Self:
        """Return the number, with its words."""
        made = super().__new__(cls, value)
        made.text, made.spreadsheet_text = shown, cell
        return made


@dataclass(frozen=True, slots=True, eq=False)
class Expression:
    """A symbol, a phasor, a number, or an `operation` on others."""

    operation: str
    operands: tuple["Expression", ...] = ()
    text: str = ""
    spreadsheet_text: str = ""
    value: complex = math.nan
    __array_ufunc__: ClassVar[None] = None  # a number of NumPy's leaves its operations to it

    def __array_namespace__(self, **_: Any) -> Any:
        """Return the library that functions of the physics compute with."""
        return _SymbolicNamespace

    # Nothing is added to what is literally 0, or multiplied by 1; of quotients one is made, and
    # what is less than nothing is taken away.

    def __add__(self, other: Any) -> "Expression":
        b = _formula(other)
        if self.value == 0 or b.value == 0:
            return b if self.value == 0 else self
        return self - b.operands[0] if b.operation == "neg" else Expression("+", (self, b))

    def __sub__(self, other: Any) -> "Expression":
        b = _formula(other)
        if self.value == 0 or b.value == 0:
            return -b if self.value == 0 else self
        return self + b.operands[0] if b.operation == "neg" else Expression("-", (self, b))

    def __mul__(self, other: Any) -> "Expression":
        b = _formula(other)
        if self.value == 0 or b.value == 0:
            return _formula(0)
        if self.value == 1 or b.value == 1:
            return b if self.value == 1 else self
        if b.operation == "/":
            return self * b.operands[0] / b.operands[1]
        if self.operation == "/":
            return self.operands[0] * b / self.operands[1]
        return Expression("*", (self, b))

    def __truediv__(self, other: Any) -> "Expression":
        b = _formula(other)
        if self.value == 0:
            return self
        if b.operation == "/":
            return self * b.operands[1] / b.operands[0]
        if self.operation == "/":
            return self.operands[0] / (self.operands[1] * b)
        return Expression("/", (self, b))

    def __pow__(self, other: Any) -> "Expression":
        return Expression("^", (self, _formula(other)))

    def __radd__(self, other: Any) -> "Expression":
        return _formula(other) + self

    def __rsub__(self, other: Any) -> "Expression":
        return _formula(other) - self

    def __rmul__(self, other: Any) -> "Expression":
        return _formula(other) * self

    def __rpow__(self, other: Any) -> "Expression":
        return _formula(other) ** self

    def __rtruediv__(self, other: Any) -> "Expression":
        return _formula(other) / self

    def __neg__(self) -> "Expression":
        return (
            self
            if self.value == 0
            else self.operands[0]
            if self.operation == "neg"
            else _of("neg")(self)
        )

    def __abs__(self) -> "Expression":
        return _of("abs")(self)

    def conj(self) -> "Expression":
        """Return the complex conjugate."""
        return _of("conj")(self)

    def real_and_imaginary(self) -> "tuple[Expression, Expression]":
        """Return its real and its imaginary part, each without phasors.

        Those of a phasor are symbols called by its name, with " re" and " im" behind.

        Raises
        ------
        ValueError
            If it divides by a complex number, or takes a root or a higher power of one.
        """
        none, of = _formula(0), [one.real_and_imaginary() for one in self.operands]
        match self.operation, of:
            case "phasor", _:
                re_, im_ = symbols(f"{self.text} re", f"{self.text} im")
                return re_, im_
            case "number", _:
                return _formula(self.value.real, self), _formula(self.value.imag)
            case "+", [(a, b), (c, d)]:
                return a + c, b + d
            case "-", [(a, b), (c, d)]:
                return a - c, b - d
            case "*", [(a, b), (c, d)]:
                return a * c - b * d, a * d + b * c
            case "/", [(a, b), (c, d)] if d.value == 0:
                return a / c, b / c
            case "^", [(a, b), _] if b.value != 0 and self.operands[1].value == 2:
                return a**2 - b**2, 2 * a * b
            case "neg", [(a, b)]:
                return -a, -b
            case "conj", [(a, b)]:
                return a, -b
            case "exp", [(a, b)] if a.value == 0:
                return _of("cos")(b), _of("sin")(b)
            case "abs", [(a, b)] if b.value != 0:
                return _of("sqrt")(a**2 + b**2), none
            case head, _ if all(b.value == 0 for _, b in of):
                return Expression(head, tuple(a for a, _ in of)) if of else self, none
            case _:
                msg = f"no spreadsheet holds {self} in two cells as it stands"
                raise ValueError(msg)

    def __str__(self) -> str:
        """Return it as plain text."""
        return _printed(self, _TEXT, lambda leaf: leaf.text)

    @property
    def latex(self) -> str:
        """It in LaTeX's mathematics."""
        return _printed(self, _LATEX, _set)

    def to_spreadsheet(self, **where: CellReference) -> str:
        """Return it for a spreadsheet, without its =, of what holds its symbols there."""
        return self.to_spreadsheet_pair(**where)[0]

    def to_spreadsheet_pair(self, **where: CellReference) -> tuple[str, str]:
        """Return its real and its imaginary part, as `to_spreadsheet` returns the real one."""
        named: dict[str, str] = {}
        for name, held in where.items():
            both = (f"{name} re", f"{name} im")
            named |= {name: held} if isinstance(held, str) else zip(both, held, strict=True)

        def cell(leaf: Expression) -> str:
            return named[leaf.text] if leaf.operation == "symbol" else leaf.spreadsheet_text

        re_, im_ = self.real_and_imaginary()
        return _printed(re_, _CELLS, cell), _printed(im_, _CELLS, cell)


def symbols(*names: str) -> tuple[Any, ...]:
    """Return symbols that stand for real numbers."""
    return tuple(Expression("symbol", text=name) for name in names)


def complex_symbols(*names: str) -> tuple[Any, ...]:
    """Return symbols that stand for complex numbers."""
    return tuple(Expression("phasor", text=name) for name in names)


def trace_expression(function: Callable[..., Any], *names: str, **named: str) -> Expression:
    """Return what a function computes of real numbers, by the names of symbols for them."""
    return function(
        *symbols(*names), **{key: Expression("symbol", text=s) for key, s in named.items()}
    )


def _formula(of: Any, like: Expression | None = None) -> Expression:
    """Return a number as a formula; it prints `like` another if it is the same."""
    if isinstance(of, Expression):
        return of
    if like is not None and of == like.value:
        return like
    if isinstance(of, ConstantWithDisplayText):
        return Expression("number", text=of.text, spreadsheet_text=of.spreadsheet_text, value=of)
    if isinstance(of, complex):
        if not of.imag or of.real:
            return _formula(of.real) + (_formula(1j * of.imag) if of.imag else 0)
        shown = "i" if of.imag == 1 else f"{of.imag:g}i"
        return Expression("number", text=shown, value=of)
    if of < 0:
        return -_formula(-of)
    third = f"{round(3 * of)}/3"  # what decimals do not end
    rounded = abs(3 * of - round(3 * of)) < 1e-12 and of != round(of)
    shown, cell = (third, third) if rounded else (f"{of:.12g}", f"{of:.15g}")
    return Expression("number", text=shown, spreadsheet_text=cell, value=of)


def _of(head: str) -> Callable[..., Expression]:
    """Return what makes an operation of formulas and numbers."""
    return lambda *of: Expression(head, tuple(map(_formula, of)))


class _SymbolicNamespace:
    """What a function finds in an array library, for symbols."""

    float64 = float
    pi = ConstantWithDisplayText(math.pi, "π", "PI()")
    sqrt, exp, maximum, conj = _of("sqrt"), _of("exp"), _of("max"), _of("conj")

    @staticmethod
    def asarray(value: Any, **_: Any) -> Expression:
        return _formula(value)

    @staticmethod
    def abs(value: Expression) -> Expression:
        return abs(value)

    @staticmethod
    def hypot(a: Expression, b: Expression) -> Expression:
        return _of("sqrt")(a**2 + b**2)


# How an operation prints: how firmly the whole holds together, its words, and how firmly each of
# its parts has to, or is put in brackets.
_Style: TypeAlias = dict[str, tuple[int, str, tuple[int, ...]]]
_TEXT: _Style = {
    "+": (1, "{} + {}", (1, 2)), "-": (1, "{} − {}", (1, 2)), "neg": (1, "−{}", (3,)),
    "/": (2, "{} / {}", (3, 4)), "*": (3, "{} {}", (3, 3)), "^": (4, "{}^{}", (5, 5)),
    "sqrt": (4, "√{}", (5,)), "conj": (4, "{}*", (5,)), "exp": (4, "e^({})", (0,)),
    "abs": (5, "|{}|", (0,)), "max": (5, "max({}, {})", (0, 0)),
}  # fmt: skip
_LATEX: _Style = {
    "+": (1, "{} + {}", (1, 2)), "-": (1, "{} - {}", (1, 2)), "neg": (1, "-{}", (3,)),
    "/": (4, r"\frac{{{}}}{{{}}}", (0, 0)), "*": (3, r"{} \, {}", (3, 3)),
    "^": (4, "{}^{{{}}}", (5, 0)), "sqrt": (5, r"\sqrt{{{}}}", (0,)),
    "conj": (4, "{}^{{*}}", (5,)), "exp": (4, "e^{{{}}}", (0,)),
    "abs": (5, r"\lvert {} \rvert", (0,)), "max": (5, r"\max({}, {})", (0, 0)),
}  # fmt: skip
# A spreadsheet's sign binds before its power, and of powers the left one before the right; its
# MAX would make one number of two ranges.
_CELLS: _Style = {
    "+": (1, "{}+{}", (1, 1)), "-": (1, "{}-{}", (1, 2)), "neg": (5, "(-{})", (5,)),
    "/": (2, "{}/{}", (2, 3)), "*": (2, "{}*{}", (2, 2)), "^": (3, "{}^{}", (5, 5)),
    "sqrt": (5, "SQRT({})", (0,)), "abs": (5, "ABS({})", (0,)), "cos": (5, "COS({})", (0,)),
    "sin": (5, "SIN({})", (0,)), "max": (5, "(({0}>{1})*({0}-{1})+{1})", (2, 2)),
}  # fmt: skip
_RAISED = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
_LEVEL = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹₀₁₂₃₄₅₆₇₈₉ₖ₊₋", "01234567890123456789k+-")


def _printed(
    of: Expression, style: _Style, leaf: Callable[[Expression], str], level: int = 0
) -> str:
    """Return a formula in a style, in brackets where it holds less firmly than a level."""
    if of.operands:
        own, words, levels = style[of.operation]
        parts = (_printed(p, style, leaf, k) for p, k in zip(of.operands, levels, strict=True))
        said = words.format(*parts)
        if style is _TEXT and of.operation == "^" and (power := of.operands[1].text).isdigit():
            said = said.removesuffix(f"^{power}") + power.translate(_RAISED)
    else:
        said = leaf(of)
        own = 5 if _whole(said) else 3 if style is not _CELLS and "·" in of.text else 0
    if own >= level:
        return said
    return rf"\left({said}\right)" if style is _LATEX else f"({said})"


def _whole(said: str) -> bool:
    """Return whether what stands for a symbol holds together: a name, a reference, a call."""
    bare = re.sub(r"'[^']*'", "", said)
    while (less := re.sub(r"[({][^(){}]*[)}]", "", bare)) != bare:
        bare = less
    return not re.search(r"[-+*/^&=<>· ]", bare)


def _set(leaf: Expression) -> str:
    """Return a symbol or a number in LaTeX: nc is n with an index c."""
    if leaf.operation == "number":
        raised = re.sub("[⁰¹²³⁴⁵⁶⁷⁸⁹]+", lambda m: f"^{{{m[0].translate(_LEVEL)}}}", leaf.text)
        return re.sub("√(\\d+)", r"\\sqrt{\1}", raised.replace("·", r" \cdot "))
    first, index = leaf.text[0], leaf.text[1:].translate(_LEVEL)
    return f"{first}_{{{index}}}" if index else first
