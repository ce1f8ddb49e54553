# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The page in a cell of a notebook."""
from __future__ import annotations

from collections.abc import Sequence

from hst_drive.measure.compare import Comparison
from hst_drive.measure.run import Run
from hst_drive.report.markup import element
from hst_drive.report.page import page
from hst_drive.report.provenance import HELD_OUT, provenance, TRAINING
from hst_drive.report.variants import variants_of
from hst_drive.rig import Rig

_POINTS = 2_000     # of a curve: a cell is narrow, and the notebook keeps what it shows


def whole_page(content: dict, rig: Rig, runs: Sequence[Run], comparison: Comparison,
               sentence: str, diagnosis: dict | None = None, held_out: int = 0, *,
               height: int) -> str:
    """
    Return the page of 'hst-drive report' in a frame of its own.

    Parameters
    ----------
    content, rig : dict, Rig
        Mapping of the rig file, and what it says.
    runs, comparison : sequence of Run, Comparison
        Logs as they were read, and with that rig.
    sentence : str
        The answer.
    diagnosis : dict, optional
        What 'diagnose --json' writes.
    held_out : int
        So many of the logs, the last, are held out.
    height : int
        Of the frame, pixels.

    """
    variants = variants_of(content, rig, runs, comparison, diagnosis, 'diagnosis')
    roles = [TRAINING] * (len(runs) - held_out) + [HELD_OUT] * held_out
    source = provenance(rig, runs, [run.source for run in runs], roles, 'import hst_drive')
    names = ', '.join(run.name for run in runs[:3]) + (', …' if len(runs) > 3 else '')
    text = page(f'{names} against {rig.name}', sentence, variants, source, diagnosis,
                points=_POINTS)
    return str(element('iframe', srcdoc=text, sandbox='allow-scripts', width='100%',
                       height=height, style='border: 1px solid #d0d7de', title=sentence))
