# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Run the cells of a notebook as Jupyter does, the value of a last line shown as HTML."""
import ast
import json
import linecache
from pathlib import Path
import sys


def run(path):
    """Run a notebook; return the variables that it leaves."""
    names = {'__name__': '__main__'}
    for number, cell in enumerate(json.loads(Path(path).read_text(encoding='utf-8'))['cells']):
        if cell['cell_type'] != 'code':
            continue
        source, filename = ''.join(cell['source']), f'<cell {number}>'
        linecache.cache[filename] = (len(source), None, source.splitlines(True), filename)
        body = ast.parse(source, filename)
        last = body.body.pop() if isinstance(body.body[-1], ast.Expr) else None
        exec(compile(body, filename, 'exec'), names)
        if last is not None:
            value = eval(compile(ast.Expression(last.value), filename, 'eval'), names)
            getattr(value, '_repr_html_', value.__repr__ if value is not None else str)()
    return names


if __name__ == '__main__':
    found = run(sys.argv[1])
    print(json.dumps({'verdict': found['found'].verdict, 'effects': list(found['found'].effects)}))
