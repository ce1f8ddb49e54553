// Copyright 2026 hst_drive contributors
// SPDX-License-Identifier: Apache-2.0
// What the page asks the server, and what it tells the user of mistakes.
'use strict';

const Talk = (() => {
  const {make} = Controls;
  const byId = (id) => document.getElementById(id);

  function alert(text) {
    const close = make('button', {type: 'button', 'aria-label': 'close'}, '×');
    const line = make('p', {}, make('span', {}, text), close);
    close.addEventListener('click', () => line.remove());
    byId('alerts').replaceChildren(line);
  }

  async function ask(name, content = {}) {
    let answer;
    try {
      answer = await fetch(`api/${name}`, {method: 'POST', body: JSON.stringify(content),
        headers: {'Content-Type': 'application/json'}});
    } catch (problem) {
      throw new Error('The workbench does not answer. Is its terminal still open? Start it again '
        + 'there: hst-drive workbench');
    }
    const found = await answer.json();
    if (!answer.ok) throw new Error(found.error);
    return found;
  }

  const unpack = (entry) => Object.fromEntries(Object.entries(entry).map(([key, value]) => [key,
    key === 'time' ? Draw.unpack(value) : ['inputs', 'measured', 'model', 'error'].includes(key)
      ? Object.fromEntries(Object.entries(value).map(([name, text]) =>
        [name, Draw.unpack(text)])) : value]));

  return {alert, ask, unpack};
})();
