# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A comparison as text and as JSON."""
from __future__ import annotations

from collections.abc import Sequence

from hst_drive.channels import CHANNELS, COMMANDS
from hst_drive.measure.balances import closed, is_part
from hst_drive.measure.compare import Comparison, LogComparison
from hst_drive.measure.errors import ErrorSummary
from hst_drive.measure.plausibility import drifts, unit_doubts
from hst_drive.measure.replay import SIGNALS
from hst_drive.measure.run import Run
from hst_drive.measure.useful import too_slow
from hst_drive.measure.where import Region, TRANSIENT
from hst_drive.report.terminal import table
from hst_drive.rig import Rig
from hst_drive.rig.rig import OPEN, WHOLE
from hst_drive.units import difference_from_si, from_si

_MOST_SPANS = 12
_CLEAR = 1.25   # a noise ratio above it is an error to look at


def remarks(rig: Rig, runs: Sequence[Run]) -> list[str]:
    """Return what the readers of logs noted, and what in them looks wrong."""
    lines = []
    for entry in runs:
        lines += [f'{entry.name}: {note}' for note in entry.notes]
        lines += _by_part(rig, entry)
        if slow := too_slow(rig, entry):
            lines.append(f'{entry.name}: {slow}')
        lines += [f'{entry.name}: {line}; mend the unit or the sign (scale: -1 in --channels), '
                  'or leave the column out'
                  for line in unit_doubts(rig, entry)]
    return lines + [drift.told for drift in drifts(rig, runs)]


def _by_part(rig: Rig, run: Run) -> list[str]:
    """Say why a log of a whole drive, or of what may be one, is judged by its balances alone."""
    lacks = [name for name in WHOLE if getattr(rig, name) is None]
    if not is_part(run, rig) or rig.circuit != OPEN or lacks and not {*COMMANDS} <= {
            *run.channels}:
        return []
    why = (f"'{rig.source or rig.name}' has no section {', '.join(lacks)}" if lacks else
           'which needs pump_command and pprv_command')
    found = closed(run, rig)
    unseen = [CHANNELS[name].title for name in SIGNALS if name in run and name not in found]
    return [f'{run.name}: no replay of the whole drive, {why}; judged one by one: '
            + ', '.join(balance.name for balance in found.values())
            + (f'; not judged: {", ".join(unseen)}' if lacks and unseen else '')]


def text(result: Comparison, most_regions: int = 8) -> str:
    """Return the comparison for a terminal."""
    lines = [sentence(result), '']
    lines.append(_table(result.signals))
    if len(result.logs) > 1:
        rows = [[log.run.name, *(log.signals[name].noise_ratio if name in log.signals else None
                                 for name in result.signals)] for log in result.logs]
        lines += ['', 'error over floor, log by log:', table(['log', *result.signals], rows)]
    if result.where:
        lines += ['', 'where the error sits:', _where(result.where[:most_regions])]
    elif _worst(result)[1] > _CLEAR:
        lines += ['', 'where the error sits: nothing sticks out; it is spread over the whole '
                  'range of operation']
    delays = [f'{log.run.name}: {name} is {abs(delay) * 1e3:.1f} ms '
              f'{"late" if delay > 0 else "early"}' for log in result.logs
              for name, delay in log.delays.items()
              if abs(delay) > max(0.2 * log.sample_time, 1e-3)]
    delays += [f'{log.run.name}: the clocks of commands and readings differ by '
               f'{1e3 * log.shift:.0f} ms; the commands were moved' for log in result.logs
               if log.shift]
    if delays:
        lines += ['', 'timing (measured against model):', *delays]
    left_out = [line for log in result.logs for line in _left_out(log)]
    if left_out:
        lines += ['', "not judged, as in 'diagnose' ('compare --all' judges it):", *left_out]
    cut = [_told(log) for log in result.logs if log.sections]
    lines += ['', *cut] if cut else []
    return '\n'.join(lines)


def _left_out(log: LogComparison) -> list[str]:
    spans = [f'{span.start:.2f} to {span.end:.2f} s ({span.why})'
             for span in log.judged.left_out[:_MOST_SPANS]]
    more = log.judged.left_out[_MOST_SPANS:]
    if more:
        seconds = sum(span.end - span.start for span in more)
        spans.append(f'and {seconds:.0f} s in {len(more)} more')
    lines = [f'{log.run.name}: {"; ".join(spans)}'] if spans else []
    lines += [f'{log.run.name}: {name}, of which no row can be judged' for name in log.unjudged]
    return lines + [f'{log.run.name}: {why} makes {100 * share:.0f} % of the log, so it is judged '
                    'all the same: too little would be left without'
                    for why, share in log.judged.kept.items()]


def _worst(result: Comparison) -> tuple[str, float]:
    """Return the signal that the model meets worst, and its error over the floor."""
    ratios = {name: entry.noise_ratio for name, entry in result.signals.items() if entry.samples}
    return max(ratios.items(), key=lambda item: item[1])


def sentence(result: Comparison) -> str:
    """Say how well the model fits."""
    worst, ratio = _worst(result)
    logs = f'{len(result.logs)} logs' if len(result.logs) > 1 else result.logs[0].run.name
    judged = sum(entry.samples > 0 for entry in result.signals.values())
    which = 'worst' if judged > 1 else 'judged by one signal alone'
    if ratio <= _CLEAR:
        return f"{logs}: '{result.rig}' explains the measurements down to the noise " \
               f'({which}: {CHANNELS[worst].title}, {ratio:.2f} x floor).'
    return f"{logs}: '{result.rig}' does not explain the measurements: the error of " \
           f'{CHANNELS[worst].title} is {ratio:.1f} times what a perfect model would show.'


def _table(signals: dict[str, ErrorSummary]) -> str:
    return table(['signal', 'rmse', 'bias', 'max', 'noise', 'floor', 'x floor', 'fit %',
                  'Russell M %', 'P %', 'C %'], [error_row(*item) for item in signals.items()])


def error_row(name: str, entry: ErrorSummary) -> list:
    """Return the row of a signal: title, five errors in its unit, over the floor, percentages."""
    unit = CHANNELS[name].display
    return [f'{CHANNELS[name].title} [{unit}]',
            *(float(difference_from_si(value, unit)) for value in (
                entry.rmse, entry.bias, entry.max_abs, entry.noise_std, entry.floor)),
            entry.noise_ratio, 100 * entry.fit, *(100 * value for value in entry.russell)]


def range_of(region: Region) -> tuple[str, float, float, str]:
    """Return the variable that a region is a range of, its ends and their unit, for people."""
    if region.variable == TRANSIENT:
        return 'rate of pressure', region.low / 1e5, region.high / 1e5, 'bar/s'
    channel = CHANNELS[region.variable]
    return (channel.title, *(from_si(end, channel.display) for end in (region.low, region.high)),
            channel.display)


def _where(regions: list[Region]) -> str:
    rows = []
    for region in regions:
        title, low, high, unit = range_of(region)
        rows.append([CHANNELS[region.signal].title, f'{title} {low:.4g} to {high:.4g} {unit}',
                     f'{100 * region.share_of_error:.0f} %', f'{100 * region.share_of_time:.0f} %',
                     f'{100 * region.explained:.0f} %'])
    return table(['error of', 'at', 'share of error', 'share of time', 'explained by it'], rows)


def as_json(result: Comparison, rig: str) -> dict:
    """Return the comparison in the form of schema hst_drive/comparison/1."""
    return {
        'schema': 'hst_drive/comparison/1', 'rig': rig or result.rig,
        'logs': [log.run.source for log in result.logs], 'closed_loop': result.closed_loop,
        'signals': _signals_json(result.signals),
        'where': [region._asdict() for region in result.where],
        'by_log': [{'log': log.run.source, 'signals': _signals_json(log.signals),
                    'delays': {'unit': 's', **log.delays}, **_left_out_json(log),
                    **({'sections': log.sections._asdict()} if log.sections else {})}
                   for log in result.logs],
    }


def _left_out_json(log: LogComparison) -> dict:
    return {'seconds_left_out': log.judged.seconds_left_out,
            'left_out': [{**span._asdict(), 'unit': 's'} for span in log.judged.left_out],
            'too_much_to_leave_out': log.judged.kept}


def _signals_json(signals: dict[str, ErrorSummary]) -> dict:
    return {name: {**entry._asdict(), 'russell': entry.russell._asdict()}
            for name, entry in signals.items()}


def _told(log: LogComparison) -> str:
    """Say how a log was cut; nothing if it was not."""
    cut = log.sections
    if cut is None:
        return ''
    return (f'{log.run.name}: compared in {cut.count} sections of {cut.seconds / 60:g} min, each '
            f'replayed from {cut.before:g} s before to {cut.after:g} s after it; noise and floor '
            f'are means over the sections, regions are from {len(log.run)} of {cut.samples} '
            'samples')
