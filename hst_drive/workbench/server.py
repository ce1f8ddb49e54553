# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The server of the page: this machine alone, this page alone.

It listens on 127.0.0.1, and refuses requests that another site's page may have caused: a foreign
Host (DNS rebinding) or Origin, and questions that are not JSON. Nothing but the page's own files
is served.
"""
from __future__ import annotations

from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
import json
import traceback

from hst_drive.errors import InputError
from hst_drive.workbench.answers import Answers

ADDRESS = '127.0.0.1'
_LARGEST = 1 << 20      # bytes of a question
_ASSETS = {
    '/': ('hst_drive.workbench', 'workbench.html', 'text/html'),
    **{f'/{name}.css': (f'hst_drive.{package}', f'{name}.css', 'text/css')
       for package, name in (('report', 'page'), ('workbench', 'workbench'))},
    **{f'/{name}.js': (f'hst_drive.{package}', f'{name}.js', 'text/javascript')
       for package, names in (('report', ('draw', 'time_plots', 'maps', 'ladder')),
                              ('workbench', ('controls', 'talk', 'keep', 'guide', 'workbench')))
       for name in names},
}
_HEADERS = {
    'Content-Security-Policy': "default-src 'none'; script-src 'self'; connect-src 'self'; "
                               "style-src 'self' 'unsafe-inline'; img-src data:; base-uri 'none'; "
                               "form-action 'none'; frame-ancestors 'none'",
    'X-Content-Type-Options': 'nosniff', 'Referrer-Policy': 'no-referrer',
    'Cross-Origin-Resource-Policy': 'same-origin', 'Cache-Control': 'no-store',
}


class Server(ThreadingHTTPServer):
    """
    A server on 127.0.0.1.

    Parameters
    ----------
    answers : Answers
        What to answer.
    port : int
        0 takes a free one.

    """

    daemon_threads = True

    def __init__(self, answers: Answers, port: int = 0):
        self.answers = answers
        super().__init__((ADDRESS, port), _Handler)

    @property
    def hosts(self) -> tuple[str, ...]:
        """Names by which the page may call it."""
        return tuple(f'{name}:{self.server_port}' for name in (ADDRESS, 'localhost'))

    @property
    def address(self) -> str:
        """Where the page is."""
        return f'http://{ADDRESS}:{self.server_port}/'


class _Handler(BaseHTTPRequestHandler):
    server: Server
    server_version, sys_version = 'hst_drive', ''
    protocol_version = 'HTTP/1.1'
    timeout = 60

    def do_GET(self) -> None:
        if not self._trusted():
            return
        entry = _ASSETS.get(self.path)
        if entry is None:
            self._send(HTTPStatus.NOT_FOUND, b'not found', 'text/plain')
            return
        package, name, kind = entry
        self._send(HTTPStatus.OK, files(package).joinpath('assets', name).read_bytes(), kind)

    def do_POST(self) -> None:
        if not self._trusted():
            return
        content = self._question()
        if content is None:
            return
        name = self.path.removeprefix('/api/')
        if name not in self.server.answers.asked or name == self.path:
            self._json(HTTPStatus.NOT_FOUND, {'error': f'{self.path}: there is no such question'})
            return
        try:
            self._json(HTTPStatus.OK, self.server.answers.answer(name, content))
        except InputError as problem:
            self._json(HTTPStatus.BAD_REQUEST, {'error': str(problem)})
        except Exception as problem:
            traceback.print_exc()
            self._json(HTTPStatus.INTERNAL_SERVER_ERROR, {
                'error': f'{type(problem).__name__}: {problem} (not your input; the terminal of '
                         'the workbench shows where it happened)'})

    def _trusted(self) -> bool:
        """Refuse what another site's page may have caused."""
        origin = self.headers.get('Origin')
        if self.headers.get('Host') not in self.server.hosts or (
                origin is not None and origin.removeprefix('http://') not in self.server.hosts):
            self.close_connection = True
            self._send(HTTPStatus.FORBIDDEN, b'only pages of this address are answered',
                       'text/plain')
            return False
        return True

    def _question(self) -> dict | None:
        """Return the JSON of a question; None once it was refused."""
        kind = self.headers.get('Content-Type', '').partition(';')[0].strip()
        length = self.headers.get('Content-Length', '')
        content = None
        if kind == 'application/json' and length.isdecimal() and int(length) <= _LARGEST:
            try:
                content = json.loads(self.rfile.read(int(length)))
            except (ValueError, RecursionError):
                content = None
        if not isinstance(content, dict):
            self.close_connection = True
            self._json(HTTPStatus.BAD_REQUEST, {
                'error': 'expected a JSON mapping (application/json) of at most '
                         f'{_LARGEST} bytes'})
            return None
        return content

    def _json(self, status: HTTPStatus, content: object) -> None:
        self._send(status, json.dumps(content, allow_nan=False).encode(), 'application/json')

    def _send(self, status: HTTPStatus, content: bytes, kind: str) -> None:
        self.send_response(status)
        self.send_header('Content-Type', f'{kind}; charset=utf-8')
        self.send_header('Content-Length', str(len(content)))
        for name, value in _HEADERS.items():
            self.send_header(name, value)
        self.end_headers()
        try:
            self.wfile.write(content)
        except (BrokenPipeError, ConnectionResetError):
            self.close_connection = True    # the page has gone, or asks something newer

    def log_message(self, *args) -> None:
        """Say nothing: the page shows what matters."""
