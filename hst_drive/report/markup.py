# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Small pieces of HTML; whatever comes from outside is escaped here."""
from __future__ import annotations

from html import escape
import math
from typing import Iterable, Sequence


class Markup(str):
    """Text that is HTML already; what is added to it is escaped."""

    def __add__(self, other: object) -> Markup:
        return Markup(str(self) + text(other))


def text(value: object) -> Markup:
    """Return a value as escaped HTML."""
    return value if isinstance(value, Markup) else Markup(escape(str(value)))


def element(tag: str, *content: object, **attributes: object) -> Markup:
    """Return an element; ``class_`` gives class, other underscores become hyphens."""
    listed = ''.join(f' {name.rstrip("_").replace("_", "-")}="{escape(str(value))}"'
                     for name, value in attributes.items() if value is not None)
    return Markup(f'<{tag}{listed}>{"".join(map(text, content))}</{tag}>')


def join(parts: Iterable[object], between: str = '\n') -> Markup:
    """Return pieces in a row."""
    return Markup(between.join(text(part) for part in parts))


def number(value: float | None, digits: int = 3) -> str:
    """Return a number for people; a dash where there is none."""
    if value is None or math.isnan(value):
        return '–'
    if math.isinf(value):
        return '∞' if value > 0 else '−∞'
    if value and not 1e-3 <= abs(value) < 1e6:
        return f'{value:.{digits - 1}e}'.replace('-', '−')
    magnitude = math.floor(math.log10(abs(value))) if value else 0
    return f'{value:.{max(digits - 1 - magnitude, 0)}f}'.replace('-', '−')


def table(header: Sequence[object], rows: Sequence[Sequence[object]], caption: str = '') -> Markup:
    """
    Return a table in a box of its own that scrolls sideways where the window is narrow.

    Numbers stand to the right; the first cell of a row is its head.
    """
    def cell(place: int, value: object) -> Markup:
        if isinstance(value, (int, float)) or value is None:
            return element('td', value if isinstance(value, int) else number(value), class_='n')
        if place == 0:
            return element('th', value, scope='row')
        return element('td', value)

    numeric = [bool(rows) and all(isinstance(row[place], (int, float)) or row[place] is None
                                  for row in rows) for place in range(len(header))]
    head = element('tr', *(element('th', title, scope='col', class_='n' if right else None)
                           for title, right in zip(header, numeric)))
    body = [element('tr', *(cell(place, value) for place, value in enumerate(row)))
            for row in rows]
    return element('div', element('table', element('caption', caption) if caption else '',
                                  element('thead', head), element('tbody', *body)),
                   class_='scroll', tabindex=0, role='region', aria_label=caption or 'table')


def section(identity: str, title: str, *content: object) -> Markup:
    """Return a section with its heading."""
    return element('section', element('h2', title, id=f'{identity}-title'), *content,
                   id=identity, aria_labelledby=f'{identity}-title')


def note(*content: object) -> Markup:
    """Return a remark that explains a figure or a table."""
    return element('p', *content, class_='note')


def plot(identity: str, label: str) -> Markup:
    """Return the place of a chart."""
    return element('div', class_='plot', id=identity, role='group', aria_label=label)
