// Copyright 2026 hst_drive contributors
// SPDX-License-Identifier: Apache-2.0
// The static page: unpacks the curves and keeps the plots in step with the choices.
'use strict';

(() => {
  const data = JSON.parse(document.getElementById('data').textContent);
  const byId = (id) => document.getElementById(id);
  const unpacked = new Map();
  const open = (entry) => {
    if (!unpacked.has(entry)) {
      const made = {...entry};
      for (const key of ['inputs', 'measured', 'model', 'error']) {
        if (entry[key]) {
          made[key] = Object.fromEntries(Object.entries(entry[key]).map(([name, text]) =>
            [name, Draw.unpack(text)]));
        }
      }
      if (entry.time) made.time = Draw.unpack(entry.time);
      unpacked.set(entry, made);
    }
    return unpacked.get(entry);
  };

  const plots = new TimePlots(byId('curve-plots'), data.titles);
  const curves = () => {
    const place = Number(byId('log').value), variant = Number(byId('variant').value);
    const log = open(data.logs[place]);
    plots.show(log, open(data.variants[variant].logs[place]));
    byId('thinned').textContent = log.thinned > 1
      ? `Of each ${log.thinned} samples the least and the greatest are shown.` : '';
  };
  const where = () => {
    const found = data.variants[Number(byId('where-variant').value)].fails;
    const signal = data.signals[Number(byId('where-signal').value)];
    Maps.map(byId('map'), found[signal].map, data.titles);
    Maps.strips(byId('strips'), found[signal], signal, data.titles);
  };
  const ladder = () => {
    if (data.ladder) Ladder.show(byId('ladder-plot'), data.ladder, data.titles);
  };
  const button = (text, label, act) => {
    const made = document.createElement('button');
    made.type = 'button';
    made.textContent = text;
    made.setAttribute('aria-label', label);
    made.title = label;
    made.addEventListener('click', act);
    byId('view-buttons').append(made);
  };

  button('+', 'zoom in', () => plots.zoomBy(0.5));
  button('−', 'zoom out', () => plots.zoomBy(2));
  button('all', 'show the whole log', () => plots.zoom(...plots.full));
  for (const id of ['log', 'variant']) byId(id).addEventListener('change', curves);
  for (const id of ['where-variant', 'where-signal']) byId(id).addEventListener('change', where);

  // The signal with the largest error first.
  const ratios = data.signals.map((name) => data.variants[0].logs.reduce((most, log) =>
    Math.max(most, log.ratio[name] || 0), 0));
  byId('where-signal').value = String(ratios.indexOf(Math.max(...ratios)));
  curves();
  where();
  ladder();
  let width = document.body.clientWidth;
  addEventListener('resize', () => {
    if (document.body.clientWidth === width) return;
    width = document.body.clientWidth;
    where();
    ladder();
  });
  addEventListener('beforeprint', () => {
    for (const details of document.querySelectorAll('details')) details.open = true;
  });
})();
