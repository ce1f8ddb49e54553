# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The server: this machine alone, this page alone."""
from http.client import HTTPConnection
import json
from threading import Thread
from types import SimpleNamespace

from hst_drive.errors import InputError
from hst_drive.workbench.server import Server
import pytest


def refuse(content):
    """Answer like a question with wrong input."""
    raise InputError('run.csv: not this')


@pytest.fixture(scope='module')
def server():
    """Return a running server with made-up answers."""
    asked = {'echo': lambda content: content, 'refuse': refuse,
             'break': lambda content: {}['nothing']}
    answers = SimpleNamespace(asked=asked, answer=lambda name, content: asked[name](content))
    made = Server(answers)
    thread = Thread(target=made.serve_forever, kwargs={'poll_interval': 0.05}, daemon=True)
    thread.start()
    yield made
    made.shutdown()
    made.server_close()


def ask(server, method='POST', path='/api/echo', content=b'{"a": 1}', **headers):
    """Return status, headers and body of an answer."""
    named = {'Content-Type': 'application/json', **{
        name.replace('_', '-'): value for name, value in headers.items()}}
    connection = HTTPConnection('127.0.0.1', server.server_port, timeout=10)
    connection.putrequest(method, path, skip_host='Host' in named)
    for name, value in named.items():
        connection.putheader(name, value)
    if method == 'POST' and 'Content-Length' not in named:
        connection.putheader('Content-Length', str(len(content)))
    connection.endheaders(content if method == 'POST' else None)
    answer = connection.getresponse()
    found = answer.status, dict(answer.getheaders()), answer.read()
    connection.close()
    return found


def test_it_listens_on_this_machine_alone(server):
    assert server.server_address[0] == '127.0.0.1'


def test_it_answers_its_page(server):
    own = f'127.0.0.1:{server.server_port}'
    for headers in ({}, {'Host': own}, {'Host': f'localhost:{server.server_port}'},
                    {'Origin': f'http://{own}'}):
        status, _, body = ask(server, **headers)
        assert status == 200 and json.loads(body) == {'a': 1}
    for path, kind in (('/', 'text/html'), ('/page.css', 'text/css'),
                       ('/workbench.js', 'text/javascript'), ('/maps.js', 'text/javascript')):
        status, headers, body = ask(server, 'GET', path)
        assert status == 200 and headers['Content-Type'].startswith(kind) and len(body) > 500
        assert "default-src 'none'" in headers['Content-Security-Policy']
        assert 'Access-Control-Allow-Origin' not in headers


@pytest.mark.parametrize('headers', [
    {'Host': 'evil.example'}, {'Host': 'evil.example:{port}'}, {'Host': '127.0.0.1'},
    {'Origin': 'http://evil.example'}, {'Origin': 'null'},
    {'Origin': 'http://127.0.0.1:{other}'}, {'Origin': 'https://127.0.0.1:{port}.evil.example'}])
@pytest.mark.parametrize('method, path', [('GET', '/'), ('POST', '/api/echo')])
def test_other_sites_are_refused(server, headers, method, path):
    port = server.server_port
    filled = {name: value.format(port=port, other=port + 1) for name, value in headers.items()}
    status, _, body = ask(server, method, path, **filled)
    assert status == 403 and b'"a"' not in body


@pytest.mark.parametrize('content, headers', [
    (b'{"a": 1}', {'Content_Type': 'text/plain'}),
    (b'a=1', {'Content_Type': 'application/x-www-form-urlencoded'}),
    (b'{"a": ', {}), (b'[1]', {}), (b'[' * 100_000, {}), (b'', {'Content_Length': '99999999'}),
    (b'', {'Content_Length': '-1'}), (b'', {'Content_Length': '\xb2'}), (b'\xff\xfe', {})])
def test_questions_must_be_json(server, content, headers):
    status, _, body = ask(server, content=content, **headers)
    assert status == 400 and 'expected a JSON mapping' in json.loads(body)['error']


@pytest.mark.parametrize('path', [
    '/../setup.py', '/..%2f..%2fetc/passwd', '/assets/page.css', '//etc/passwd', '/workbench.html',
    '/api/echo', '/page.css?x', '/.'])
def test_no_other_file_is_served(server, path):
    assert ask(server, 'GET', path)[0] == 404


def test_wrong_input_and_faults_reach_the_page(server, capsys):
    status, _, body = ask(server, path='/api/refuse')
    assert status == 400 and json.loads(body) == {'error': 'run.csv: not this'}
    status, _, body = ask(server, path='/api/break')
    assert status == 500 and 'KeyError' in json.loads(body)['error']
    assert 'Traceback' in capsys.readouterr().err
    assert ask(server, path='/api/none')[0] == 404
    assert ask(server, path='/echo')[0] == 404
    assert ask(server)[0] == 200
