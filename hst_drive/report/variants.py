# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The models of a page: the one that was given, and those with what a diagnosis found."""
from __future__ import annotations

from collections.abc import Callable, Sequence

from hst_drive.diagnose.adopt import adopt
from hst_drive.measure.compare import compare, Comparison, model_of, together
from hst_drive.measure.run import Run
from hst_drive.report.fit_sections import Variant
from hst_drive.rig import parse_rig, Rig


def variants_of(content: dict, rig: Rig, runs: Sequence[Run], given: Comparison,
                diagnosis: dict | None, source: str,
                progress: Callable[[str], None] = lambda text: None,
                before: int = 0) -> list[Variant]:
    """
    Compare logs with a rig and what a diagnosis found, beside the rig as it was given.

    What was found came after the last ``before`` logs: they stay as they were compared.

    Parameters
    ----------
    content, rig : dict, Rig
        Mapping of the rig file, and what it says.
    runs, given : sequence of Run, Comparison
        Logs as they were read, and with that rig.
    diagnosis, source : dict or None, str
        What 'diagnose --json' writes, and its file.
    progress : callable
        Called with a text while the work goes on.
    before : int
        So many of the logs, the last, are older: of the machine as it was.

    """
    present = len(runs) - before

    def variant(title: str, found: Comparison) -> Variant:
        # Where it fails now: what tells new logs from old ones explains no error.
        return Variant(title, found._replace(where=together(
            found.rig, found.logs[:present]).where) if before else found)

    variants = [variant('the machine as it was' if before else 'model as given', given)]
    for title, other in _adopted(content, diagnosis, source, rig):
        progress(f'comparing: {title}')
        new = compare(model_of(other, runs), runs[:present])
        variants.append(variant(title, together(other.name, [*new.logs, *given.logs[present:]])))
    return variants


def _adopted(content: dict, diagnosis: dict | None, source: str, rig: Rig) -> list[
        tuple[str, Rig]]:
    """Return the rig with what was found added, and with the formula for the unknown."""
    if not diagnosis:
        return []
    formula = (diagnosis.get('unknown') or {}).get('formula')
    kinds = ([('with what was found', False)] if diagnosis['effects'] else []) + (
        [('with the formula for the unknown', True)] if formula else [])
    return [(title, parse_rig(adopt(content, diagnosis, source, rig.source,
                                    formula=with_formula), rig.source))
            for title, with_formula in kinds]
