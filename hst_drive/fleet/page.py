# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The page of a fleet: one file without scripts that opens offline and prints."""
from __future__ import annotations

import math
from typing import Sequence

from hst_drive.fleet.picture import picture
from hst_drive.fleet.summary import (
    AHEAD, Followed, GROWS, Machine, ODD, REACHED, SOUND, Summary, THERE, UNTOLD)
from hst_drive.fleet.track import OIL
from hst_drive.fleet.words import (
    amount, day, due, goes, many, of_machine, sentence, since, size)
from hst_drive.report.markup import element, join, Markup, note, section, table
from hst_drive.report.page import asset

_POLICY = "default-src 'none'; style-src 'unsafe-inline'"
_COLOURS = {REACHED: '#b03a00', AHEAD: '#b03a00', GROWS: '#8a6100', ODD: '#5b3fa0',
            THERE: '#0072b2', SOUND: '#007a5a', UNTOLD: '#57606a'}
_STYLE = """
.state { display: inline-block; border-radius: 1rem; padding: 0 .6rem; font-weight: 600;
  border: 2px solid; font-size: .85rem; white-space: nowrap; }
.machine { border-top: 2px solid var(--line); margin-top: 1.6rem; padding-top: .2rem; }
.machine h3 { font-size: 1.15rem; margin: .8rem 0 .4rem; }
.machine ul { margin: .3rem 0 .8rem; padding-left: 1.2rem; max-width: 60rem; }
.machine figure { margin: .6rem 0 1.2rem; }
.pictures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 26rem), 1fr));
  gap: 0 1.4rem; }
.overview td, .overview th { white-space: normal; }
.overview table { width: 100%; }
.overview td:is(:nth-child(4), :nth-child(6)) { min-width: 10.5rem; }
.overview td:nth-child(5) { min-width: 6.5rem; }
@media (max-width: 50rem) {
  .overview thead, .overview td:empty { display: none; }
  .overview tbody, .overview tr, .overview :is(th, td) { display: block; border: 0; padding: 0; }
  .overview tr { border-top: 1px solid var(--line); padding: .4rem 0; }
  .overview :is(th, td):nth-child(-n+2) { display: inline-block; margin-right: .6rem; }
  .overview td:nth-child(n+4)::before { color: var(--soft); }
  .overview td:nth-child(4)::before { content: 'now '; }
  .overview td:nth-child(5)::before { content: 'since '; }
  .overview td:nth-child(6)::before { content: 'limit '; }
  .overview td:nth-child(8)::before { content: 'last log '; }
}
"""


def fleet_page(name: str, rows: Sequence[dict], summary: Summary) -> str:
    """Return the page of all campaigns as HTML; ``name`` is the folder of the fleet."""
    title = f'Fleet {name}' if name else 'Fleet'
    dates = sorted(row['date'] for row in rows if row['date'])
    facts = [many(len(summary.machines), 'machine'), many(len(rows), 'campaign'),
             *([f'{dates[0]} to {dates[-1]}'] if dates else [])]
    blocks = [
        element('header', element('h1', title),
                element('p', sentence(summary), class_='sentence'),
                element('p', ' · '.join(facts), class_='facts')),
        _overview(summary), _machines(summary), _outliers(summary), _rows(rows)]
    links = [element('a', text, href=f'#{identity}') for identity, text in (
        ('urgency', 'By urgency'), ('machines', 'Machine by machine'),
        ('outliers', 'Unlike the others'), ('campaigns', 'All campaigns'))]
    return '\n'.join([
        '<!DOCTYPE html>', '<html lang="en"><head><meta charset="utf-8">',
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        str(element('title', title)),
        f'<style>{asset("page.css")}{_STYLE}</style></head><body>',
        '<a class="skip" href="#main">Skip to the content</a>',
        str(element('nav', join(links), aria_label='Sections')),
        '<main id="main">', *map(str, blocks), '</main></body></html>', ''])


def _badge(machine: Machine) -> Markup:
    return element('span', machine.state, class_='state',
                   style=f'color: {_COLOURS[machine.state]}')


def _foremost(machine: Machine) -> Followed | None:
    """Return what a machine is listed for: the most urgent of what is there."""
    return next((entry for entry in machine.followed if entry.there and (
        entry.effect != OIL or math.isfinite(entry.due))), None)


def _overview(summary: Summary) -> Markup:
    rows = []
    for number, machine in enumerate(summary.machines):
        entry = _foremost(machine)
        last = machine.events[-1] if machine.events else None
        rows.append([
            element('a', machine.name, href=f'#machine-{number}'), _badge(machine),
            join([element('strong', entry.effect), goes(entry)], ': ') if entry
            else f'by the last log: {", ".join(machine.named)}' if machine.named else '',
            size(entry) if entry else '',
            since(entry).removeprefix('since ') if entry else '', due(entry) if entry else '',
            f'{day(last.after)} to {day(last.before)}: {last.what}' if last else '',
            element('span', machine.last, style='white-space: nowrap')])
    return section(
        'urgency', 'By urgency', element('div', table(
            ['machine', 'state', 'what', 'now (95 %)', 'since', 'limit reached', 'last event',
             'last log'], rows,
            'Machines, the most urgent first'), class_='overview'))


def _machines(summary: Summary) -> Markup:
    return section(
        'machines', 'Machine by machine',
        note('A dot is what a date says, with its 95 % interval; also where a diagnosis named '
             'nothing; a leak in oil as warm as it usually is. The band is what all laws that fit '
             '(steady, linear, from some day on, accelerating) say together, with 95 %; orange: '
             'what comes if it goes on like that. Grey: something changed between two dates. The '
             'size now is of all dates; what is not known of the machine itself, which moves all '
             'dots together, makes its interval wider.'),
        *(_machine(number, machine) for number, machine in enumerate(summary.machines)))


def _machine(number: int, machine: Machine) -> Markup:
    shown = [entry for entry in machine.followed
             if entry.growth.jumps or entry.grows or entry.effect != OIL and (
                 entry.there or entry.growth.kind != 'steady')]
    figures = [element('figure', element('figcaption', entry.effect.replace(
        OIL, 'oil stiffness')), picture(entry, f'{machine.name}: {entry.effect}'))
        for entry in shown or machine.followed[:1]]
    done = sum(machine.verdicts.values())
    return element(
        'div', element('h3', f'{machine.name} ', _badge(machine)),
        element('ul', *(element('li', told) for told in of_machine(machine))),
        element('div', *figures, class_='pictures') if figures else '',
        element('p', f'{done} of {many(machine.campaigns, "campaign")} judged; '
                f'its own file: {machine.unit}', class_='note'),
        class_='machine', id=f'machine-{number}')


def _outliers(summary: Summary) -> Markup:
    rows = [[entry.point.machine, entry.point.effect, amount(entry.point.value, entry.point.unit),
             amount(entry.median, entry.point.unit), f'{entry.z:+.1f}']
            for entry in summary.outliers]
    return section('outliers', 'Unlike the others', note(
        'Robust z beyond 3.5 among the machines that show the effect now (five at least).'),
        table(['machine', 'effect', 'size', "machines' median", 'z'], rows, 'Outliers')
        if rows else note('None.'))


def _rows(rows: Sequence[dict]) -> Markup:
    listed = [[row['campaign'], row['date'] or '', (row['diagnosis'] or {}).get('verdict') or
               row['status'], row['reason'] or (row['diagnosis'] or {}).get('sentence') or
               'taken as healthy: the machine was commissioned on it'] for row in rows]
    return section('campaigns', 'All campaigns', element(
        'details', element('summary', f'{many(len(listed), "campaign")}, with answers'),
        table(['campaign', 'date', 'verdict', 'answer, or why there is none'], listed,
              'Campaigns')))
