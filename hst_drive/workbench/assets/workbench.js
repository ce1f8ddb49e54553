// Copyright 2026 hst_drive contributors
// SPDX-License-Identifier: Apache-2.0
// The workbench: holds the model, asks the server for curves and errors, and shows them.
'use strict';

(async () => {
  const {make} = Controls;
  const byId = (id) => document.getElementById(id);

  const {alert, ask, unpack} = Talk;
  const given = await ask('start');
  const measured = new Map(), ghosts = new Map();
  let model = given.model, startErrors = null, lastErrors = null, fails = null;
  let past = [];          // models to go back to, each with the label of the change that followed
  let steps = [];         // rungs of the ladder
  let label = 'start', busy = false, serial = 0, begun = 0;
  const page = String(Math.random()).slice(2);

  const plots = new TimePlots(byId('curve-plots'), given.titles);
  const effects = new Controls.Effects(byId('effects'), given.effects, change);

  function change(next, what) {
    // A slider that moves makes one step, not hundreds.
    const same = past.length && past[past.length - 1].what === what && what.includes(':');
    if (!same) past.push({model, what});
    model = next;
    label = what;
    begun = performance.now();
    paintModel();
    update();
  }

  function paintModel() {
    effects.show(model);
    byId('undo').disabled = !past.length;
    const rows = Object.entries(model.factors).filter(([, factor]) => Math.abs(factor - 1) > 1e-6);
    byId('factors-box').hidden = !rows.length;
    const clear = make('button', {type: 'button'}, 'back to the datasheet');
    clear.addEventListener('click', () => change({...model, factors: {}}, '− calibration'));
    byId('factors').replaceChildren(make('table', {}, make('tbody', {}, ...rows.map(
      ([key, factor]) => make('tr', {}, make('th', {scope: 'row'}, key),
        make('td', {class: 'n'}, factor.toFixed(4)))))), clear);
  }

  // First what one replay tells; when the user rests, the numbers of compare.
  async function update() {
    serial += 1;
    if (busy) return;       // the loop below sees the new model
    busy = true;
    let mine, asked, what, since;
    do {
      [mine, asked, what, since] = [serial, model, label, begun];
      try {
        await quick(asked, since);
      } catch (problem) {
        if (mine === serial) { busy = false; failed(problem); return; }
      }
    } while (mine !== serial);
    busy = false;
    exact(mine, asked, what, since);
  }

  const failed = (problem) => {
    alert(problem.message);
    document.body.dataset.failed = problem.message;
  };
  const seconds = (since) => ((performance.now() - since) / 1000).toFixed(2);

  async function quick(asked, since) {
    const log = Number(byId('log').value);
    if (!since || !measured.has(log)) return;
    const near = await ask('quick', {model: asked, log, page, serial});
    if (near.curves) plots.show(measured.get(log), unpack(near.curves), ghost(log));
    showErrors(near.signals, '≈ ');
    await new Promise((done) => { requestAnimationFrame(() => setTimeout(done)); });
    document.body.dataset.took = seconds(since);
    byId('took').textContent = `Shown in ${seconds(since)} s.`;
  }

  async function exact(mine, asked, what, since) {
    const stale = () => mine !== serial;
    try {
      await showLog(asked, mine, stale);
      if (stale()) return;
      const found = await ask('errors', {model: asked, page, serial: mine});
      if (stale()) return;
      byId('alerts').replaceChildren();
      if (found.lost.length) alert(found.lost.join(' · '));
      showErrors(found.signals, '');
      step(found.signals, what);
      const told = document.body.dataset.took;
      byId('took').textContent = since && told
        ? `Shown in ${told} s, as compare counts in ${seconds(since)} s.` : '';
      await showWhere(asked, mine, stale);
      if (stale()) return;
      document.body.dataset.shown = JSON.stringify(asked);
    } catch (problem) {
      if (!stale()) failed(problem);
    }
  }

  const ghost = (log) => (byId('ghost').checked ? ghosts.get(log) : null);

  async function showLog(asked, mine, stale) {
    const log = Number(byId('log').value);
    const found = await ask('log', {model: asked, log, measured: !measured.has(log), page,
      serial: mine});
    if (found.log) measured.set(log, unpack(found.log));
    if (!ghosts.has(log)) {
      const first = JSON.stringify(asked) === JSON.stringify(given.model) ? found
        : byId('ghost').checked ? await ask('log', {model: given.model, log}) : null;
      if (first) ghosts.set(log, unpack(first.curves));
    }
    if (!stale()) plots.show(measured.get(log), unpack(found.curves), ghost(log));
  }

  function showErrors(signals, about) {
    const first = startErrors || signals, before = lastErrors || signals;
    const ratio = (value) => {
      const kind = value <= 1.25 ? 'good' : value <= 2 ? 'fair' : 'bad';
      return make('span', {class: `ratio ${kind}`}, Draw.number(value));
    };
    const rows = Object.entries(signals).map(([name, entry]) => {
      const {title, unit} = given.titles[name];
      const moved = entry.held === undefined ? 0 : entry.held - before[name].held;
      const arrow = Math.abs(moved) < 0.005 ? '' : moved < 0 ? ' ↓' : ' ↑';
      return make('tr', {'data-signal': name, 'data-ratio': String(entry.ratio)},
        make('th', {scope: 'row'}, title),
        make('td', {class: 'n'}, about, ratio(entry.ratio)),
        make('td', {class: 'n'}, Draw.number(entry.training)),
        make('td', {class: 'n held'}, Draw.number(entry.held),
          make('span', {class: moved < 0 ? 'down' : 'up'}, arrow)),
        make('td', {class: 'n'}, Draw.number(first[name].held)),
        make('td', {class: 'n'}, entry.rmse === undefined ? '' : `${Draw.number(entry.rmse)} ${unit}`));
    });
    byId('error-table').replaceChildren(make('table', {}, make('thead', {}, make('tr', {},
      ...['signal', 'all', 'training', 'held out', 'held out at the start', 'rmse'].map(
        (text, k) => make('th', {scope: 'col', class: k ? 'n' : ''}, text)))),
    make('tbody', {}, ...rows)));
    byId('error-table').classList.toggle('stale', about !== '' );
  }

  // A rung of the ladder.
  function step(signals, what) {
    startErrors = startErrors || signals;
    lastErrors = signals;
    const column = (part) => Object.fromEntries(Object.entries(signals).map(([name, entry]) =>
      [name, entry[part]]));
    const rung = {label: what, added: what, training: column('training'), holdout: column('held')};
    const same = steps.length > 1 && steps[steps.length - 1].label === what && what.includes(':');
    if (same) steps[steps.length - 1] = rung;
    else if (!steps.length || steps[steps.length - 1].label !== what) steps.push(rung);
    paintLadder();
  }

  function paintLadder() {
    const most = byId('ladder-plot').clientWidth < 500 ? 4 : 9;
    const shown = steps.length > most ? [steps[0], ...steps.slice(1 - most)] : steps;
    if (shown.length) Ladder.show(byId('ladder-plot'), shown, given.titles);
  }

  async function showWhere(asked, mine, stale) {
    const found = await ask('where', {model: asked, page, serial: mine});
    if (stale()) return;
    fails = found.fails;
    const choice = byId('where-signal');
    if (!choice.options.length) {
      const worst = Object.entries(lastErrors).sort((a, b) => b[1].ratio - a[1].ratio)[0][0];
      choice.append(...found.signals.map((name) => make('option', {value: name},
        given.titles[name].title)));
      choice.value = worst;
    }
    paintWhere();
  }

  function paintWhere() {
    const signal = byId('where-signal').value;
    if (!fails || !fails[signal]) return;
    Maps.map(byId('map'), fails[signal].map, given.titles);
    Maps.strips(byId('strips'), fails[signal], signal, given.titles);
  }

  async function job(name, content, done) {
    const box = byId('job');
    const stop = make('button', {type: 'button'}, 'Stop');
    const words = make('span', {}, 'starting');
    try {
      await ask(name, content);
    } catch (problem) {
      alert(problem.message);
      return;
    }
    for (const id of ['fit', 'diagnose']) byId(id).disabled = true;
    stop.addEventListener('click', () => ask('stop').catch((problem) => alert(problem.message)));
    box.replaceChildren(make('progress', {}), ' ', words, ' ', stop);
    box.hidden = false;
    try {
      for (;;) {
        const state = await ask('job');
        words.textContent = `${state.progress} (${Math.round(state.seconds)} s)`;
        if (state.state !== 'running') {
          if (state.state === 'done') done(state.result); else alert(state.error);
          break;
        }
        await new Promise((resolve) => { setTimeout(resolve, 150); });
      }
    } catch (problem) {
      alert(problem.message);
    }
    box.hidden = true;
    for (const id of ['fit', 'diagnose']) byId(id).disabled = false;
  }

  function fit() {
    const locked = [...effects.locked].map((key) => key.split('\n'));
    job('fit', {model, locked, unit: byId('unit').checked}, (found) => change(found, 'fit'));
  }

  function diagnose() {
    job('diagnose', {model}, (found) => {
      const box = byId('found');
      const body = make('div', {});
      body.innerHTML = found.badge + found.cards;     // escaped where it was made
      const close = make('button', {type: 'button'}, 'Close');
      close.addEventListener('click', () => { box.hidden = true; });
      const buttons = found.offers.map((offer) => {
        const made = make('button', {type: 'button', class: 'offer'}, offer.title);
        made.addEventListener('click', () => change(offer.model, offer.title));
        return made;
      });
      box.replaceChildren(make('p', {class: 'sentence'}, found.sentence),
        make('p', {class: 'controls'}, ...buttons, close), body);
      box.hidden = false;
      box.scrollIntoView({block: 'nearest'});
    });
  }

  function undo() {
    if (!past.length) return;
    const {model: before} = past.pop();
    model = before;
    if (steps.length > 1) steps.pop();
    label = steps.length ? steps[steps.length - 1].label : 'start';
    begun = performance.now();
    paintModel();
    update();
  }

  Keep.start(() => model);
  byId('rig').textContent = given.rig;
  given.logs.forEach((log, place) => byId('log').append(make('option', {value: String(place)},
    log.name + (log.held ? ' (held out)' : ''))));
  byId('log-label').hidden = given.logs.length < 2;
  const notes = given.logs.flatMap((log) => log.notes.map((text) => `${log.name}: ${text}`));
  for (const [id, act] of [['fit', fit], ['diagnose', diagnose], ['undo', undo],
    ['reset', () => { change(given.model, 'start over'); steps = []; }],
    ['in', () => plots.zoomBy(0.5)], ['out', () => plots.zoomBy(2)],
    ['all', () => plots.zoom(...plots.full)]]) byId(id).addEventListener('click', act);
  for (const id of ['log', 'ghost']) {
    byId(id).addEventListener('change', () => { begun = performance.now(); update(); });
  }
  byId('where-signal').addEventListener('change', paintWhere);
  byId('filter').addEventListener('input', () => effects.find(byId('filter').value));
  addEventListener('resize', () => { paintWhere(); paintLadder(); });
  addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey
        || event.target.closest('input, select, textarea')) return;
    const act = {f: fit, d: diagnose, u: undo}[event.key.toLowerCase()];
    if (act) { act(); event.preventDefault(); }
  });
  if (given.guided) {
    Guide.start(byId('guide'), (id) => effects.toggle(id, !(id in model.effects)));
  }
  paintModel();
  serial += 1;
  await exact(serial, model, label, 0);
  if (notes.length) alert(notes.join(' · '));
  document.body.dataset.ready = 'yes';
})().catch((problem) => {
  document.getElementById('alerts').textContent = problem.message;
});
