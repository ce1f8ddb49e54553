// Copyright 2026 hst_drive contributors
// SPDX-License-Identifier: Apache-2.0
// Keeping a model: as a rig file, and as a command line.
'use strict';

const Keep = (() => {
  const {make} = Controls;
  const {alert, ask} = Talk;
  const byId = (id) => document.getElementById(id);

  // model() returns the model that the page shows.
  function start(model) {
    async function save() {
      try {
        const {path, command} = await ask('save', {model: model(), name: byId('name').value});
        byId('kept').replaceChildren(`Saved ${path}. `, command ? 'The same numbers: ' : '',
          make('code', {}, command));
      } catch (problem) {
        alert(problem.message);
      }
    }

    async function copy() {
      try {
        const {command} = await ask('command', {model: model()});
        const text = make('textarea', {rows: 4, readOnly: true, 'aria-label': 'command line'});
        text.value = command;
        byId('kept').replaceChildren('Copied; run it where the logs are. ', text);
        await navigator.clipboard.writeText(command).catch(() => {
          byId('kept').firstChild.textContent = 'Copy this: ';
          text.select();
        });
      } catch (problem) {
        alert(problem.message);
      }
    }

    byId('save').addEventListener('click', save);
    byId('copy').addEventListener('click', copy);
  }

  return {start};
})();
