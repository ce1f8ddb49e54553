# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Count right and wrong answers, with Wilson's 95 % intervals."""
from collections.abc import Callable, Iterable
from math import sqrt
from statistics import median

Row = dict


def wilson(hits: int, count: int) -> tuple[float, float]:
    """Return the 95 % interval of a share (E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209)."""
    if count == 0:
        return 0.0, 1.0
    z = 1.959964
    share, over = hits / count, 1 + z * z / count
    middle = (share + z * z / (2 * count)) / over
    half = z * sqrt(share * (1 - share) / count + z * z / (4 * count * count)) / over
    return max(middle - half, 0.0), min(middle + half, 1.0)


def group(row: Row, known: Iterable[str]) -> str:
    """Return none, single, pair or unlisted; what cannot be named at all counts as unlisted."""
    truth = row['truth']
    if truth['kind'] in ('single', 'pair') and not set(truth['effects']) <= set(known):
        return 'unlisted'
    return truth['kind']


def in_set(row: Row) -> bool:
    """Tell whether each true effect is named or said to be indistinguishable from a named one."""
    return set(row['truth']['effects']) <= {*row['named'], *row['rivals']}


def misplaced(row: Row) -> bool:
    """Tell whether a verdict without reservation names what is not there."""
    return row['verdict'] == 'missing_effect' and not set(row['named']) <= set(
        row['truth']['effects'])


def unknown(row: Row) -> bool:
    """Tell whether the verdict is that no listed effect explains the data."""
    return row['verdict'] == 'unknown'


def right_place(row: Row) -> bool:
    """Tell whether the unknown is looked for where it is."""
    return unknown(row) and row['unknown_enters'] in row['truth']['enters']


ROWS: dict[str, list[tuple[str, Callable[[Row], bool]]]] = {
    'none': [
        ('false alarm', lambda r: r['verdict'] != 'none'),
        ('... of these an effect named', lambda r: bool(r['named'])),
        ('... of these unknown', unknown)],
    'single': [
        ('first name right', lambda r: r['named'][:1] == r['truth']['effects']),
        ('right name alone', lambda r: r['named'] == r['truth']['effects']),
        ('in set', in_set),
        ('unknown', unknown),
        ('none', lambda r: r['verdict'] == 'none')],
    'pair': [
        ('exactly both', lambda r: set(r['named']) == set(r['truth']['effects'])),
        ('both in set', in_set),
        ('one at least in set',
         lambda r: bool(set(r['truth']['effects']) & {*r['named'], *r['rivals']})),
        ('unknown', unknown)],
    'unlisted': [
        ('flagged (unknown)', unknown),
        ('right place', right_place),
        ('none', lambda r: r['verdict'] == 'none')],
}


def line(what: str, rows: list[Row], test: Callable[[Row], bool]) -> str:
    """Return one row of the table."""
    hits = sum(test(row) for row in rows)
    low, high = wilson(hits, len(rows))
    share = f'{100 * hits / len(rows):.0f} %' if rows else '-'
    return f'| {what} | {hits} of {len(rows)} | {share} | {100 * low:.0f} to {100 * high:.0f} |'


def middle(values: list[float | None]) -> str:
    """Return median and largest of what is there."""
    numbers = [v for v in values if v is not None]
    return f'{median(numbers):.2f}, at most {max(numbers):.2f}' if numbers else '-'


def table(rows: list[Row], known: Iterable[str]) -> str:
    """Return the table of a run."""
    failed = [row for row in rows if row['verdict'] == 'failed']
    answered = [row for row in rows if row['verdict'] != 'failed']
    lines = ['| campaigns | count | share | 95 % (Wilson) |', '|---|---|---|---|']
    for name, tests in ROWS.items():
        of = [row for row in answered if group(row, known) == name]
        lines += [line(f'{name}: {what}', of, test) for what, test in tests]
        lines.append(line(f'{name}: confident and wrong', of, misplaced))
        if name == 'single':
            for strength in ('small', 'typical', 'strong'):
                some = [row for row in of if row['truth']['strength'] == strength]
                lines.append(line(f'single, {strength}: first name right', some, tests[0][1]))
    lines.append(line('all: confident and wrong', answered, misplaced))
    lines.append(line('all: no answer', rows, lambda row: row['verdict'] == 'failed'))
    lines += ['', '| held-out, worst signal, in its noise (median) | before | after |',
              '|---|---|---|']
    for name in ROWS:
        of = [row for row in answered if group(row, known) == name]
        lines.append(f'| {name} | {middle([r["before"] for r in of])} | '
                     f'{middle([r["after"] for r in of])} |')
    lines += ['', f'Seconds for a diagnosis (median): {middle([r["seconds"] for r in rows])}']
    lines += [f'No answer: {row["campaign"]}: exit {row["exit"]}: {row["error"]}'
              for row in failed]
    return '\n'.join(lines)
