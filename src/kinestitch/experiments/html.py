"""A report as one HTML file that needs nothing beside itself, and as Markdown and JSON for the documents."""

from __future__ import annotations

import base64
import html
import json
from collections.abc import Sequence
from datetime import date

from kinestitch import __version__
from kinestitch.experiments.page import Finding, Picture, Section, Table

TITLE = "Smooth motion stitching, reproduced"
DOI = "10.48550/arXiv.2608.08986"

_STYLE = """
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, sans-serif; color: #222; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.7rem; } h2 { margin-top: 3rem; border-top: 1px solid #ddd; padding-top: 1rem; font-size: 1.3rem; }
figure { margin: 1.5rem 0; } img, video { max-width: 100%; height: auto; } figcaption { color: #555; font-size: .9rem; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; margin: .5rem 0; }
.wide { overflow-x: auto; }
th:first-child, td:first-child { min-width: 9rem; }
th, td { text-align: left; vertical-align: top; padding: .25rem .8rem .25rem 0; font-size: .92rem; }
th, td { border-bottom: 1px solid #e5e5e5; }
.verdict { display: inline-block; padding: 0 .5rem; border-radius: .6rem; font-size: .85rem; white-space: nowrap; }
.reproduced { background: #d8efe4; } .limits { background: #fdeecb; } .not { background: #f8d7d3; }
.measured { background: #e3ebf5; } .missing { background: #eee; }
.note { background: #fdeecb; padding: .5rem 1rem; }
"""
_CLASSES = {"reproduced with limits": "limits", "not reproduced": "not"}


def as_html(sections: Sequence[Section], *, data: str, day: date, note: str = "") -> str:
    """The whole report: verdicts first, then every section with its pictures, tables and videos inside."""
    body = [f"<h1>{TITLE}</h1>"]
    body.append(
        f"<p>kinestitch {html.escape(__version__)}, {day.isoformat()}, run on {html.escape(data)}. Method: "
        f'<a href="https://doi.org/{DOI}">doi:{DOI}</a>. Every number below was computed in this run.</p>'
    )
    if note:
        body.append(f'<p class="note">{html.escape(note)}</p>')
    rows = [(section, finding) for section in sections for finding in section.findings]
    body.append("<table><tr><th>claim</th><th>verdict</th><th>evidence</th></tr>")
    body += [
        f"<tr><td>{html.escape(f.claim)}</td><td>{_badge(f)}</td><td>{html.escape(f.evidence)}</td></tr>"
        for _, f in rows
    ]
    body.append("</table>")
    for number, section in enumerate(sections):
        body += _section(number, section)
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{TITLE}</title>'
        f'<meta name="viewport" content="width=device-width, initial-scale=1"><style>{_STYLE}</style></head><body>'
        + "\n".join(body)
        + "</body></html>\n"
    )


def _badge(finding: Finding) -> str:
    kind = _CLASSES.get(finding.verdict, finding.verdict)
    return f'<span class="verdict {kind}">{finding.verdict}</span>'


def _section(number: int, section: Section) -> list[str]:
    out = [f'<h2 id="s{number}">{number} · {html.escape(section.title)}</h2>', f"<p>{html.escape(section.text)}</p>"]
    out += [f"<p>{_badge(f)} <b>{html.escape(f.claim)}</b> {html.escape(f.evidence)}</p>" for f in section.findings]
    out += [_picture(picture) for picture in section.pictures]
    out += [
        f'<figure><video controls preload="metadata" src="data:video/mp4;base64,{_base64(video.data)}"></video>'
        f"<figcaption>{html.escape(video.caption)}</figcaption></figure>"
        for video in section.videos
    ]
    out += [_table(table) for table in section.tables]
    return out


def _picture(picture: Picture) -> str:
    kind = "svg+xml" if picture.kind == "svg" else "png"
    text = html.escape(picture.caption)
    return (
        f'<figure><img alt="{text}" src="data:image/{kind};base64,{_base64(picture.data)}">'
        f"<figcaption>{text}</figcaption></figure>"
    )


def _base64(data: bytes) -> str:
    return base64.b64encode(data).decode("ascii")


def _table(table: Table) -> str:
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in table.head)
    rows = "".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in table.rows)
    caption = f"<figcaption>{html.escape(table.caption)}</figcaption>"
    return f'<figure class="wide"><table><tr>{head}</tr>{rows}</table>{caption}</figure>'


def as_markdown(sections: Sequence[Section], *, data: str, day: date) -> str:
    """Verdicts and tables without pictures, for the documents: aggregate numbers only."""
    out = [
        f"# Results\n\nMade by `make reproduce` on {day.isoformat()}, run on {data}. Pictures and videos stand in "
        f"the report itself."
    ]
    out += ["", "| claim | verdict | evidence |", "|---|---|---|"]
    out += [f"| {f.claim} | {f.verdict} | {f.evidence} |" for section in sections for f in section.findings]
    for number, section in enumerate(sections):
        out += ["", f"## {number} · {section.title}", "", section.text]
        for table in section.tables:
            out += ["", "| " + " | ".join(table.head) + " |", "|" + "---|" * len(table.head)]
            out += ["| " + " | ".join(row) + " |" for row in table.rows]
            out += ["", table.caption]
    return "\n".join(out) + "\n"


def as_json(sections: Sequence[Section], *, data: str, day: date) -> str:
    """The sections' numbers by key, with the date and what they were computed on."""
    numbers: dict[str, object] = {"date": day.isoformat(), "data": data}
    for section in sections:
        numbers.update(section.numbers)
    numbers["verdicts"] = {f.claim: f.verdict for section in sections for f in section.findings}
    return json.dumps(numbers, indent=1, ensure_ascii=False) + "\n"
