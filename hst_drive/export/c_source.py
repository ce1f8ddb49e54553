# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The text of the equations as C.

``translate`` takes the part of Python in which ``kernel_template`` and the effects are written:
numbers, arrays that are only indexed, ``if``, ``while``, ``for`` over ranges, ``math``, tuples
that are returned. What it does not know is an error that names it.
"""
from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence
from typing import NamedTuple, NoReturn

_OPERATORS = {ast.Add: '+', ast.Sub: '-', ast.Mult: '*', ast.Div: '/', ast.Lt: '<', ast.LtE: '<=',
              ast.Gt: '>', ast.GtE: '>=', ast.Eq: '==', ast.NotEq: '!=', ast.And: '&&',
              ast.Or: '||', ast.USub: '-', ast.UAdd: '+', ast.Not: '!'}
# Of math, called alike in C.
_MATH = {'sqrt', 'exp', 'tanh', 'sin', 'cos', 'log', 'log10', 'atan', 'ceil', 'floor', 'isnan',
         'hypot', 'copysign', 'tan', 'sinh', 'cosh', 'atan2', 'pow', 'fabs', 'asin', 'acos',
         'expm1', 'log1p'}
_CONSTANTS = {'pi': '3.14159265358979323846', 'nan': 'NAN', 'inf': 'INFINITY',
              'e': '2.71828182845904523536', 'tau': '6.28318530717958647693'}
PROLOGUE = """#include <math.h>
#include <string.h>

/* As Python's: the first of two that are equal, or of which one is no number. */
static double least(double a, double b) { return b < a ? b : a; }
static double most(double a, double b) { return b > a ? b : a; }
static long least_of(long a, long b) { return b < a ? b : a; }
static long most_of(long a, long b) { return b > a ? b : a; }
"""


class Array(NamedTuple):
    """An array that a function takes: C type of its items, and items in a row (1: a vector)."""

    item: str
    row: int = 1


class Untranslatable(ValueError):
    """A construct of Python that is not known here."""


def translate(source: str, arrays: Mapping[str, Array], rows: int,
              integers: Sequence[str] = (), leave_out: Sequence[str] = ()) -> str:
    """
    Return a module of the kernel's kind as C.

    Parameters
    ----------
    source : str
        Python.
    arrays : mapping of str to Array
        Arguments that are arrays, by name, in whichever function they are.
    rows : int
        Length of those of which the length is asked.
    integers : sequence of str
        Arguments that are whole numbers.
    leave_out : sequence of str
        Functions that nobody calls.

    Raises
    ------
    Untranslatable
        At what is not known; names it and its line.

    """
    constants: dict[str, str] = {}
    functions: list[ast.FunctionDef] = []
    for node in ast.parse(source).body:
        if isinstance(node, ast.FunctionDef) and node.name not in leave_out:
            functions.append(node)
        elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            constants[node.targets[0].id] = ast.unparse(node.value)
    widths = {node.name: _width(node) for node in functions}
    known = _Known(constants, arrays, frozenset(integers), widths)
    bodies = [_Function(node, known) for node in functions]
    return '\n'.join([
        PROLOGUE, f'#define ROWS {rows}',
        *(f'#define {name} {value}' for name, value in constants.items()), '',
        *(f'{body.head};' for body in bodies), '', *(body.text for body in bodies)])


class _Known(NamedTuple):
    """What all functions share: constants, arrays, whole numbers, how many each returns."""

    constants: dict[str, str]
    arrays: Mapping[str, Array]
    integers: frozenset[str]
    widths: dict[str, int]


def _width(node: ast.FunctionDef) -> int:
    """Return how many numbers a function returns: 0 nothing, 1 one."""
    widths = {len(entry.value.elts) if isinstance(entry.value, ast.Tuple) else 1
              for entry in ast.walk(node) if isinstance(entry, ast.Return) and entry.value}
    if len(widths) > 1:
        raise Untranslatable(f'{node.name}: returns now {min(widths)}, now {max(widths)} numbers')
    return widths.pop() if widths else 0


class _Function:
    """One function; ``head`` declares it."""

    def __init__(self, node: ast.FunctionDef, known: _Known):
        self._known = known
        self._width = known.widths[node.name]
        self._arguments = [entry.arg for entry in node.args.args]
        self._whole = {name for name in self._arguments if name in known.integers}
        self._types = {entry.id: 'double' for entry in ast.walk(node)
                       if isinstance(entry, ast.Name) and isinstance(entry.ctx, ast.Store)}
        # Whole numbers first known make others known.
        while self._settle(node):
            pass
        arguments = [f'{known.arrays[name].item} *{name}' if name in known.arrays
                     else f'{"long" if name in self._whole else "double"} {name}'
                     for name in self._arguments]
        if self._width > 1:
            arguments.append('double *returned')
        kind = 'double' if self._width == 1 else 'void'
        self.head = f'static {kind} {node.name}({", ".join(arguments)})'
        declared = [f'    {kind} {name} = 0;' for name, kind in self._types.items()
                    if name not in self._arguments]
        self.text = '\n'.join([self.head, '{', *declared, *self._block(node.body, 1), '}', ''])

    def _settle(self, node: ast.FunctionDef) -> bool:
        """Find variables that only ever get whole numbers; say whether there was a new one."""
        given: dict[str, list[ast.expr | None]] = {}
        for entry in ast.walk(node):
            if isinstance(entry, ast.Assign):
                for target in entry.targets:
                    if isinstance(target, ast.Tuple):
                        values = (entry.value.elts if isinstance(entry.value, ast.Tuple)
                                  else [None] * len(target.elts))
                        for name, value in zip(target.elts, values):
                            given.setdefault(ast.unparse(name), []).append(value)
                    else:
                        given.setdefault(ast.unparse(target), []).append(entry.value)
            elif isinstance(entry, ast.AugAssign):
                given.setdefault(ast.unparse(entry.target), []).append(
                    entry.value if not isinstance(entry.op, ast.Div) else None)
            elif isinstance(entry, ast.For):
                self._whole.add(ast.unparse(entry.target))
                self._types[ast.unparse(entry.target)] = 'long'
        new = [name for name, values in given.items() if name in self._types
               and self._types[name] == 'double'
               and all(value is not None and self._is_whole(value) for value in values)]
        for name in new:
            self._types[name] = 'long'
            self._whole.add(name)
        return bool(new)

    def _is_whole(self, node: ast.expr) -> bool:
        if isinstance(node, ast.Constant):
            return isinstance(node.value, int)
        if isinstance(node, ast.Name):
            return node.id in self._whole or (
                node.id in self._known.constants and self._known.constants[node.id].isdecimal())
        if isinstance(node, ast.Subscript):
            return self._array(node).item != 'double' and self._array(node).item != 'const double'
        if isinstance(node, ast.BinOp):
            return not isinstance(node.op, (ast.Div, ast.Pow)) and (
                self._is_whole(node.left) and self._is_whole(node.right))
        if isinstance(node, ast.UnaryOp):
            return isinstance(node.op, ast.Not) or self._is_whole(node.operand)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            return node.func.id in ('int', 'len') or (
                node.func.id in ('min', 'max', 'abs') and all(map(self._is_whole, node.args)))
        if isinstance(node, ast.BoolOp):
            return all(map(self._is_whole, node.values))
        return isinstance(node, ast.Compare)

    def _array(self, node: ast.Subscript) -> Array:
        name = ast.unparse(node.value)
        if name not in self._known.arrays:
            self._refuse(node)
        return self._known.arrays[name]

    def _refuse(self, node: ast.AST) -> NoReturn:
        raise Untranslatable(f'line {getattr(node, "lineno", 0)}: {ast.unparse(node)[:60]!r} '
                             f'({type(node).__name__}) is nothing that can be said in C here')

    def _block(self, nodes: Sequence[ast.stmt], depth: int) -> list[str]:
        pad = '    ' * depth
        return [pad + line if line else line for node in nodes for line in self._statement(node)]

    def _statement(self, node: ast.stmt) -> list[str]:
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            return []       # a docstring
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
            return [f'{self._expression(node.value)};']
        if isinstance(node, ast.Pass):
            return []
        if isinstance(node, ast.Break):
            return ['break;']
        if isinstance(node, ast.Return):
            return self._return(node)
        if isinstance(node, ast.AugAssign):
            return [f'{self._expression(node.target)} {self._sign(node.op, node)}= '
                    f'{self._expression(node.value)};']
        if isinstance(node, ast.Assign):
            return self._assign(node)
        if isinstance(node, ast.If):
            lines = [f'if ({self._expression(node.test)}) {{', *self._block(node.body, 1)]
            if node.orelse:
                lines += ['} else {', *self._block(node.orelse, 1)]
            return [*lines, '}']
        if isinstance(node, ast.While):
            return [f'while ({self._expression(node.test)}) {{', *self._block(node.body, 1), '}']
        if isinstance(node, ast.For):
            return self._for(node)
        self._refuse(node)

    def _return(self, node: ast.Return) -> list[str]:
        if node.value is None:
            return ['return;']
        if isinstance(node.value, ast.Tuple):
            return [*(f'returned[{place}] = {self._expression(value)};'
                      for place, value in enumerate(node.value.elts)), 'return;']
        return [f'return {self._expression(node.value)};']

    def _assign(self, node: ast.Assign) -> list[str]:
        targets = node.targets
        if len(targets) == 1 and isinstance(targets[0], ast.Tuple):
            names = [self._expression(name) for name in targets[0].elts]
            if isinstance(node.value, ast.Tuple):
                values = [self._expression(value) for value in node.value.elts]
                # All of them before any: Python swaps so.
                return ['{', *(f'    double t{place} = {value};'
                               for place, value in enumerate(values)),
                        *(f'    {name} = t{place};' for place, name in enumerate(names)), '}']
            call = self._expression(node.value)
            return ['{', f'    double t[{len(names)}];', f'    {call[:-1]}, t);',
                    *(f'    {name} = t[{place}];' for place, name in enumerate(names)), '}']
        value = self._expression(node.value)
        return [f'{" = ".join(self._expression(target) for target in targets)} = {value};']

    def _for(self, node: ast.For) -> list[str]:
        call = node.iter
        if not (isinstance(call, ast.Call) and ast.unparse(call.func) == 'range'
                and len(call.args) < 3):
            self._refuse(node)
        ends = [self._expression(entry) for entry in call.args]
        first, last = ('0', ends[0]) if len(ends) == 1 else ends[:2]
        name = self._expression(node.target)
        return [f'for ({name} = {first}; {name} < {last}; {name}++) {{',
                *self._block(node.body, 1), '}']

    def _expression(self, node: ast.AST) -> str:
        if isinstance(node, ast.Constant):
            if isinstance(node.value, bool):
                return str(int(node.value))
            if isinstance(node.value, (int, float)):
                return repr(node.value)
        elif isinstance(node, ast.Name):
            return node.id
        elif isinstance(node, ast.Attribute) and ast.unparse(node.value) == 'math' and (
                node.attr in _CONSTANTS):
            return _CONSTANTS[node.attr]
        elif isinstance(node, ast.Subscript):
            return self._subscript(node)
        elif isinstance(node, ast.UnaryOp):
            return f'({self._sign(node.op, node)}{self._expression(node.operand)})'
        elif isinstance(node, ast.BinOp):
            return self._binary(node)
        elif isinstance(node, ast.BoolOp):
            mark = f' {self._sign(node.op, node)} '
            return f'({mark.join(map(self._expression, node.values))})'
        elif isinstance(node, ast.IfExp):
            test, yes, no = map(self._expression, (node.test, node.body, node.orelse))
            return f'({test} ? {yes} : {no})'
        elif isinstance(node, ast.Compare):
            return self._compare(node)
        elif isinstance(node, ast.Call):
            return self._call(node)
        self._refuse(node)

    def _sign(self, operator: ast.AST, node: ast.AST) -> str:
        if type(operator) not in _OPERATORS:
            self._refuse(node)
        return _OPERATORS[type(operator)]

    def _subscript(self, node: ast.Subscript) -> str:
        whole = ast.unparse(node)
        if whole.endswith('.shape[1]') and whole.removesuffix('.shape[1]') in self._known.arrays:
            return str(self._known.arrays[whole.removesuffix('.shape[1]')].row)
        name, array = ast.unparse(node.value), self._array(node)
        if isinstance(node.slice, ast.Tuple):
            row, column = map(self._expression, node.slice.elts)
            return f'{name}[({row}) * {array.row} + {column}]'
        return f'{name}[{self._expression(node.slice)}]'

    def _binary(self, node: ast.BinOp) -> str:
        left, right = self._expression(node.left), self._expression(node.right)
        if isinstance(node.op, ast.Pow):
            if isinstance(node.right, ast.Constant) and node.right.value == 2:
                return f'({left} * {left})'
            return f'pow({left}, {right})'
        if isinstance(node.op, ast.Div):
            return f'((double)({left}) / {right})'
        return f'({left} {self._sign(node.op, node)} {right})'

    def _compare(self, node: ast.Compare) -> str:
        terms = [self._expression(entry) for entry in (node.left, *node.comparators)]
        return '(' + ' && '.join(
            f'({first} {self._sign(mark, node)} {second})'
            for first, mark, second in zip(terms, node.ops, terms[1:])) + ')'

    def _call(self, node: ast.Call) -> str:
        values = [self._expression(entry) for entry in node.args]
        if isinstance(node.func, ast.Attribute) and ast.unparse(node.func.value) == 'math':
            if node.func.attr not in _MATH:
                self._refuse(node)
            return f'{node.func.attr}({", ".join(values)})'
        name = ast.unparse(node.func)
        whole = self._is_whole(node)
        if name in ('min', 'max'):
            pair = {'min': 'least', 'max': 'most'}[name] + ('_of' if whole else '')
            found = values[0]
            for value in values[1:]:
                found = f'{pair}({found}, {value})'
            return found
        if name == 'abs':
            return f'fabs({values[0]})'
        if name == 'int':
            return f'((long)({values[0]}))'
        if name == 'float':
            return f'((double)({values[0]}))'
        if name == 'len':
            return 'ROWS'
        if name not in self._known.widths:
            self._refuse(node)
        return f'{name}({", ".join(values)})'
