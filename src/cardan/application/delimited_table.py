"""Tables as spreadsheets copy and save them: the sign between columns and the decimal sign."""

from cardan.application.paste_import import interpretations_of_ambiguous_number


def divided_rows(text: str) -> list[tuple[int, list[str]]]:
    """Return the cells of each row that has any, by the sign that divides the first, with its line.

    Tabs divide where there is one, else semicolons, else commas.
    """
    lines = text.splitlines()
    first = next((one for one in lines if one.strip()), "")
    sign = next((s for s in ("\t", ";") if s in first), ",")
    rows = ((k, [c.strip().strip('"') for c in one.split(sign)]) for k, one in enumerate(lines, 1))
    return [(k, cells) for k, cells in rows if any(cells)]


def decimal_sign(numbers: list[str]) -> str:
    """Return the decimal sign of a table: the one that some number can have as nothing else."""
    for number in numbers:
        last = max(number.rfind("."), number.rfind(","))
        if last < 0:
            continue
        sign, other = number[last], "," if number[last] == "." else "."
        alone = number.count(sign) == 1
        if alone and not interpretations_of_ambiguous_number(number, decimal=other):
            return sign
    # No number decides: one that may be either is then refused, whichever sign is taken.
    return "," if any("." in n for n in numbers) else "."
