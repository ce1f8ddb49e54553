# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The static page: one file that holds all it needs and opens without a network."""
from __future__ import annotations

from importlib.resources import files
import json
import re
from typing import Sequence

from hst_drive.plain import plain
from hst_drive.report.curves import measured_curves, model_curves, points_each, titles
from hst_drive.report.fails import error_maps
from hst_drive.report.fit_sections import (
    curves_section, errors_section, notes_section, Variant, where_section)
from hst_drive.report.found_sections import (
    found_section, ladder_section, rivals_section, unit_section, verdict)
from hst_drive.report.markup import element, join, Markup, section, table
from hst_drive.report.provenance import BEFORE, HELD_OUT, Provenance

_HEADING = re.compile('<h2 id="([a-z]+)-title">(.*?)</h2>')
SCRIPTS = ('draw.js', 'time_plots.js', 'maps.js', 'ladder.js', 'report.js')
# Nothing may be fetched, whatever a log's name or a channel's says.
POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:"


def page(title: str, sentence: str, variants: Sequence[Variant], source: Provenance,
         diagnosis: dict | None = None, remark: str = '', points: int | None = None) -> str:
    """
    Return the page as HTML.

    Parameters
    ----------
    title, sentence : str
        Heading, and the answer in one sentence.
    variants : sequence of Variant
        The models to show, the given rig first; all compared with the same logs.
    source : Provenance
        What the page rests on.
    diagnosis : dict, optional
        What 'diagnose --json' writes.
    remark : str
        What the reader should know besides, e.g. why there is no diagnosis.
    points : int, optional
        Of a curve, at most; by default as many as fit into a page.

    """
    variants = list(variants)
    blocks = [_header(title, sentence, variants, source, diagnosis, remark)]
    if diagnosis:
        blocks += [ladder_section(diagnosis), found_section(diagnosis)]
    before = sum(entry.role == BEFORE for entry in source.sources)
    blocks += [curves_section(variants), where_section(variants),
               errors_section(variants, before)]
    if diagnosis:
        blocks += [rivals_section(diagnosis), unit_section(diagnosis)]
    blocks.append(_provenance(source))
    script = '\n'.join(map(asset, SCRIPTS))
    data = json.dumps(plain(_data(variants, diagnosis, points)), allow_nan=False)
    return '\n'.join([
        '<!DOCTYPE html>', '<html lang="en"><head><meta charset="utf-8">',
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        '<meta name="referrer" content="no-referrer">',
        str(element('title', title)), f'<style>{asset("page.css")}</style></head><body>',
        '<a class="skip" href="#main">Skip to the content</a>', _navigation(blocks),
        '<main id="main">', *map(str, blocks), '</main>',
        '<noscript><p class="remark">The plots need JavaScript; the numbers stand in the tables.'
        '</p></noscript>',
        f'<script type="application/json" id="data">{data.replace("<", chr(92) + "u003c")}'
        '</script>', f'<script>{script}</script></body></html>', ''])


def asset(name: str) -> str:
    """Return the text of a file of the folder ``assets``."""
    return files('hst_drive.report').joinpath('assets', name).read_text(encoding='utf-8')


def _header(title: str, sentence: str, variants: list[Variant], source: Provenance,
            diagnosis: dict | None, remark: str) -> Markup:
    logs = variants[0].comparison.logs
    seconds = sum(float(log.run.time[-1] - log.run.time[0]) for log in logs)
    held, before = (sum(entry.role == role for entry in source.sources)
                    for role in (HELD_OUT, BEFORE))
    facts = [f'{len(logs)} {"log" if len(logs) == 1 else "logs"}, {_duration(seconds)}'
             + (f', {held} of them held out' if held else '')
             + (f', {before} from when it was commissioned' if before else ''),
             f'rig: {source.rig}', source.date]
    return element(
        'header', element('h1', title), verdict(diagnosis) if diagnosis else '',
        element('p', sentence, class_='sentence'),
        element('p', ' · '.join(facts), class_='facts'),
        element('p', remark, class_='remark') if remark else '',
        notes_section(variants[0].comparison))


def _duration(seconds: float) -> str:
    return f'{seconds:.0f} s' if seconds < 600 else f'{seconds / 60:.0f} min'


def _navigation(blocks: Sequence[str]) -> str:
    found = [_HEADING.search(block) for block in blocks]
    links = [element('a', Markup(match[2]), href=f'#{match[1]}') for match in found if match]
    return str(element('nav', join(links), aria_label='Sections'))


def _provenance(source: Provenance) -> Markup:
    rows = [[entry.path, entry.role, entry.samples, entry.seconds, entry.rate,
             f'{entry.bytes / 1e6:.2f} MB', element('code', entry.sha256, class_='hash')]
            for entry in source.sources]
    facts = {'rig': source.rig, 'rig file': source.rig_file, 'rig identity': source.rig_digest,
             'command': source.command, 'written': source.date,
             **{f'version of {name}': value for name, value in source.versions.items()}}
    return section(
        'provenance', 'What this page rests on',
        table(['log', 'used for', 'samples', 'seconds', 'samples/s', 'size', 'SHA-256'], rows,
              'Logs'),
        element('dl', join(element('dt', key) + element('dd', value)
                           for key, value in facts.items()), class_='facts-list'))


def _data(variants: list[Variant], diagnosis: dict | None, points: int | None) -> dict:
    first = variants[0].comparison
    points = points or points_each(first.logs, len(variants))
    names = list(first.signals)
    return {
        'titles': titles(), 'signals': names,
        'logs': [measured_curves(log, points) for log in first.logs],
        'variants': [{
            'title': entry.title,
            'logs': [model_curves(log, points) for log in entry.comparison.logs],
            'fails': error_maps(entry.comparison.logs, names)} for entry in variants],
        'ladder': diagnosis and diagnosis.get('ladder'),
    }
