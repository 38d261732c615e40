"""Tables and blocks of pages that a command writes: they stand between two marks."""

from __future__ import annotations

from collections.abc import Sequence

MARK = "<!-- {what} {name}: made by scripts/make_docs.py recordings -->"


def with_table(text: str, name: str, head: str, rows: dict[str, str], names: Sequence[str]) -> str:
    """Return the page with new rows in the table between its two marks; others stay.

    Args:
        text: The page.
        name: Of the table.
        head: Its two first lines.
        rows: New lines by their first cell: a name, or a name, a colon and more.
        names: In which order rows stand.

    Raises:
        ValueError: If the marks are not there.
    """
    _, old, _ = _around(text, name)
    kept = {line.split("|")[1].strip(): line for line in old.splitlines()[3:] if "|" in line}
    order = {known: number for number, known in enumerate(names)}
    all_rows = sorted(
        (kept | rows).items(), key=lambda row: order.get(row[0].split(":")[0], len(order))
    )
    return with_block(text, name, head + "\n".join(row for _, row in all_rows))


def with_block(text: str, name: str, block: str) -> str:
    """Return the page with other lines between its two marks.

    Raises:
        ValueError: If the marks are not there.
    """
    before, _, after = _around(text, name)
    begin, end = (MARK.format(what=what, name=name) for what in ("begin", "end"))
    return f"{before}{begin}\n{block}\n{end}{after}"


def _around(text: str, name: str) -> tuple[str, str, str]:
    """Return what is before, between and behind two marks."""
    begin, end = (MARK.format(what=what, name=name) for what in ("begin", "end"))
    before, found, rest = text.partition(begin)
    old, closed, after = rest.partition(end)
    if not (found and closed):
        raise ValueError(f"the page lacks the line {begin} or {end}")
    return before, old, after


def row_of(cells: Sequence[object]) -> str:
    """Return a line of a table."""
    return "| " + " | ".join(str(cell) for cell in cells) + " |"
