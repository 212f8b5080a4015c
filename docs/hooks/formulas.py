"""Formulas as MathML, which browsers draw themselves: no script, no font to fetch.

In the text, `$...$` and `$$...$$` hold LaTeX, as they do on code hosts.
"""

import html
import re
from typing import Any

from latex2mathml.converter import convert

_INLINE = re.compile(r'<span class="arithmatex">\\\((.*?)\\\)</span>', re.DOTALL)
_BLOCK = re.compile(r'<div class="arithmatex">\s*\\\[(.*?)\\\]\s*</div>', re.DOTALL)


def on_page_content(text: str, **_: Any) -> str:
    """Returns a page's HTML with its formulas as MathML."""
    text = _INLINE.sub(lambda found: _mathml(found[1], "inline"), text)
    return _BLOCK.sub(
        lambda found: f'<div class="formula">{_mathml(found[1], "block")}</div>', text
    )


def _mathml(tex: str, display: str) -> str:
    return str(convert(html.unescape(tex).strip(), display=display))
