"""Formulas as MathML, which browsers draw themselves: no script, no font to fetch.

In the text, `$...$` and `$$...$$` hold LaTeX, as they do on code hosts.
"""

import html
import re
from typing import Any

from latex2mathml.converter import convert

_INLINE = re.compile(r'<span class="arithmatex">\\\((.*?)\\\)</span>', re.DOTALL)
_BLOCK = re.compile(r'<div class="arithmatex">\s*\\\[(.*?)\\\]\s*</div>', re.DOTALL)

_FUNCTION = re.compile(r"(<mi>(?:sin|cos|tanh|exp|ln)</mi>)(<mo[^>]*>&#x00028;)?")
_BAR = re.compile(r"<mo[^>]*>(&#x0007C;|&#x02016;)</mo>")
_GAP = '<mspace width="0.17em"/>'


def on_page_content(text: str, **_: Any) -> str:
    """Returns a page's HTML with its formulas as MathML."""
    text = _INLINE.sub(lambda found: _mathml(found[1], "inline"), text)
    return _BLOCK.sub(
        lambda found: f'<div class="formula">{_mathml(found[1], "block")}</div>', text
    )


def _mathml(tex: str, display: str) -> str:
    text = str(convert(html.unescape(tex).strip(), display=display))
    # Bars are as high as a letter; a function's name stands apart from its neighbours.
    text = _BAR.sub(r"<mi>\1</mi>", text)
    return _FUNCTION.sub(_spaced, text)


def _spaced(found: re.Match[str]) -> str:
    """Returns a function's name with gaps; none before a bracket."""
    name, bracket = found.groups()
    after = "" if bracket else _GAP
    return f"<mrow>{_GAP}{name}{after}</mrow>{bracket or ''}"
