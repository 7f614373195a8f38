"""What the site needs beyond MkDocs: formulas as MathML, and links to files of the repository, checked."""

from __future__ import annotations

import html
import logging
import posixpath
import re
from pathlib import Path
from typing import Any

from latex2mathml.converter import convert

ROOT = Path(__file__).parents[1]
REPOSITORY = "https://github.com/mmmdmtsp/workbench/blob/main/"

FORMULA = re.compile(r'<(span|div) class="arithmatex">\\[(\[](.*?)\\[)\]]</\1>', re.S)
LINK = re.compile(r"(?<=\]\()\.\.?/[^)\s#]+(?=[)#])")

log = logging.getLogger("mkdocs.hooks")


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Turn links to files outside docs/ into links to the repository; one that leads nowhere is a warning."""
    folder = posixpath.dirname(page.file.src_uri)

    def absolute(link: re.Match[str]) -> str:
        path = posixpath.normpath(posixpath.join("docs", folder, link.group()))
        if path.startswith("docs/"):
            return link.group()
        if not (ROOT / path).exists():
            log.warning("%s: links to %s, which does not exist", page.file.src_uri, path)
        return REPOSITORY + path

    return LINK.sub(absolute, markdown)


def on_page_content(content: str, **_: Any) -> str:
    """Turn $…$ and $$…$$, which arithmatex marked, into MathML: no script, no request."""

    def mathml(found: re.Match[str]) -> str:
        return convert(html.unescape(found.group(2)).strip(), display="block" if found.group(1) == "div" else "inline")

    return FORMULA.sub(mathml, content)
