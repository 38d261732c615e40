"""One self-contained HTML page from titles, texts, figures, tables and pictures."""

from __future__ import annotations

import base64
import html
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

_STYLE = """
:root { color-scheme: light dark; --ink: #1d2733; --soft: #5d6b7a; --line: #dbe1e8;
  --page: #f5f7f9; --card: #ffffff; --good: #1a7f4b; --bad: #b3261e; }
@media (prefers-color-scheme: dark) { :root { --ink: #e4e9ef; --soft: #98a5b3; --line: #303a46;
  --page: #14191f; --card: #1c232b; --good: #5bc58d; --bad: #ff8a80; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--page); color: var(--ink); line-height: 1.5;
  font: 16px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, Helvetica, Arial, sans-serif; }
main { max-width: 1180px; margin: 0 auto; padding: 28px 20px 60px; }
h1 { font-size: 1.7rem; margin: 0; } h2 { font-size: 1.15rem; margin: 0 0 10px; }
.subtitle { color: var(--soft); margin: 2px 0 20px; }
section { background: var(--card); border: 1px solid var(--line); border-radius: 10px;
  padding: 18px 20px; margin: 0 0 18px; }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(140px, 1fr)); gap: 12px; }
.figures div { border-left: 3px solid var(--line); padding-left: 10px; }
.figures div.good { border-color: var(--good); } .figures div.bad { border-color: var(--bad); }
.figures b { display: block; font-size: 1.35rem; font-variant-numeric: tabular-nums; }
.figures span { color: var(--soft); font-size: .85rem; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
.scroll { overflow-x: auto; }
th, td { text-align: left; padding: 5px 12px 5px 0; border-bottom: 1px solid var(--line); }
th { color: var(--soft); font-weight: 600; font-size: .85rem; }
td.number { text-align: right; } th.number { text-align: right; }
figure { margin: 12px 0 4px; } figure img { max-width: 100%; height: auto; border-radius: 6px;
  background: #fff; } figcaption { color: var(--soft); font-size: .9rem; margin-top: 4px; }
pre { overflow-x: auto; background: var(--page); padding: 10px; border-radius: 6px; }
p { margin: 6px 0; } footer { color: var(--soft); font-size: .85rem; }
"""


@dataclass(frozen=True)
class Figures:
    """Key figures shown large: `(name, value)`, or `(name, value, "good" | "bad")`."""

    items: list[tuple[str, ...]]


@dataclass(frozen=True)
class Table:
    """A table; numbers are set to the right."""

    header: list[str]
    rows: list[list[Any]]


@dataclass(frozen=True)
class Picture:
    """A PNG file to embed."""

    path: Path
    caption: str = ""


@dataclass(frozen=True)
class Preformatted:
    """Text shown as it is, such as the last lines of a log."""

    text: str


Block = str | Figures | Table | Picture | Preformatted


@dataclass(frozen=True)
class Section:
    """A titled part of the page; a plain string among its blocks is a paragraph."""

    title: str
    blocks: list[Block] = field(default_factory=list)


def render_page(title: str, sections: list[Section], subtitle: str = "") -> str:
    """Return the page as HTML."""
    parts = "\n".join(_section(section) for section in sections)
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{html.escape(title)}</title><style>{_STYLE}</style></head>\n<body><main>"
        f'<h1>{html.escape(title)}</h1><p class="subtitle">{html.escape(subtitle)}</p>\n'
        f"{parts}\n<footer>floornav</footer></main></body></html>\n"
    )


def _section(section: Section) -> str:
    title = f"<h2>{html.escape(section.title)}</h2>" if section.title else ""
    return f"<section>{title}{''.join(_block(block) for block in section.blocks)}</section>"


def _block(block: Block) -> str:
    if isinstance(block, Figures):
        return f'<div class="figures">{"".join(_figure(item) for item in block.items)}</div>'
    if isinstance(block, Table):
        return _table(block)
    if isinstance(block, Picture):
        return _picture(block)
    if isinstance(block, Preformatted):
        return f"<pre>{html.escape(block.text)}</pre>"
    return f"<p>{html.escape(block)}</p>"


def _figure(item: tuple[str, ...]) -> str:
    mark = f' class="{item[2]}"' if len(item) > 2 and item[2] in ("good", "bad") else ""
    return f"<div{mark}><b>{html.escape(item[1])}</b><span>{html.escape(item[0])}</span></div>"


def _table(table: Table) -> str:
    numeric = [
        bool(table.rows) and all(_is_number(row[k]) for row in table.rows)
        for k in range(len(table.header))
    ]
    css = [' class="number"' if is_number else "" for is_number in numeric]
    head = "".join(f"<th{c}>{html.escape(h)}</th>" for c, h in zip(css, table.header, strict=True))
    rows = "".join(
        "<tr>" + "".join(f"<td{c}>{_cell(v)}</td>" for c, v in zip(css, row, strict=True)) + "</tr>"
        for row in table.rows
    )
    return f'<div class="scroll"><table><tr>{head}</tr>{rows}</table></div>'


def _is_number(value: Any) -> bool:
    return value is None or (isinstance(value, int | float) and not isinstance(value, bool))


def _cell(value: Any) -> str:
    if value is None:
        return "–"
    return html.escape(f"{value:.4g}" if isinstance(value, float) else str(value))


def _picture(picture: Picture) -> str:
    data = base64.b64encode(picture.path.read_bytes()).decode("ascii")
    caption = html.escape(picture.caption)
    image = f'<img alt="{caption}" src="data:image/png;base64,{data}">'
    return f"<figure>{image}<figcaption>{caption}</figcaption></figure>"
