// Copyright 2026 hst_drive contributors
// SPDX-License-Identifier: Apache-2.0
// The ladder: how the error falls, step by step.
'use strict';

const Ladder = (() => {
  const {LEFT, RIGHT, draw, canvas, number} = Draw;
  // Okabe and Ito's colours, told apart by colour-blind readers; marks differ as well.
  const COLOURS = ['#0072B2', '#D55E00', '#009E73', '#CC79A7', '#000000', '#56B4E9', '#E69F00',
    '#5b3fa0', '#7a7a7a'];
  const MARKS = ['circle', 'square', 'triangle', 'diamond', 'cross', 'down'];

  function mark(parent, kind, x, y, colour, filled) {
    const r = 5, style = {fill: filled ? colour : '#fff', stroke: colour, 'stroke-width': 1.6};
    const shapes = {
      circle: () => draw('circle', {cx: x, cy: y, r, ...style}, parent),
      square: () => draw('rect', {x: x - r, y: y - r, width: 2 * r, height: 2 * r, ...style}, parent),
      triangle: () => draw('path', {d: `M${x} ${y - r - 1}l${r + 1} ${2 * r}h${-2 * r - 2}Z`,
        ...style}, parent),
      down: () => draw('path', {d: `M${x} ${y + r + 1}l${r + 1} ${-2 * r}h${-2 * r - 2}Z`,
        ...style}, parent),
      diamond: () => draw('path', {d: `M${x} ${y - r - 1.5}l${r} ${r + 1.5}l${-r} ${r + 1.5}`
        + `l${-r} ${-r - 1.5}Z`, ...style}, parent),
      cross: () => draw('path', {d: `M${x - r} ${y - r}l${2 * r} ${2 * r}m0 ${-2 * r}`
        + `l${-2 * r} ${2 * r}`, ...style, 'stroke-width': filled ? 3 : 1.4}, parent),
    };
    return shapes[kind]();
  }

  // The error over the floor after each step: held-out data filled, training data hollow.
  function show(element, steps, titles) {
    element.textContent = '';
    const width = Math.max(element.clientWidth, 280), height = 330, bottom = height - 52;
    const names = Object.keys(steps[0].holdout);
    const all = steps.flatMap((step) => names.flatMap((name) =>
      [step.holdout[name], step.training[name]])).filter((value) => value > 0);
    const low = Math.log(Math.min(0.7, ...all) * 0.9), high = Math.log(Math.max(2, ...all) * 1.15);
    const y = (value) => bottom - (Math.log(value) - low) / (high - low) * (bottom - 26);
    const slot = (width - LEFT - RIGHT) / steps.length;
    const picture = canvas(element, width, height, 'error over the noise floor, step by step');
    for (const value of [0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000]) {
      if (Math.log(value) < low || Math.log(value) > high) continue;
      draw('path', {class: 'grid', d: `M${LEFT} ${y(value)}H${width - RIGHT}`}, picture);
      draw('text', {class: 'tick', x: LEFT - 6, y: y(value) + 4, 'text-anchor': 'end'}, picture,
        String(value));
    }
    draw('path', {class: 'axis', 'stroke-dasharray': '6 4', style: 'stroke:#000;stroke-width:1.5',
      d: `M${LEFT} ${y(1)}H${width - RIGHT}`}, picture);
    draw('text', {class: 'tick', x: 4, y: 13}, picture, 'error over the noise floor');
    steps.forEach((step, k) => {
      const middle = LEFT + (k + 0.5) * slot;
      const words = (step.label || `${k > 1 ? '+ ' : ''}${step.added}`).split(/(?<=[_ ])/);
      const lines = [''], fits = Math.max(Math.floor(slot / 7), 7);
      for (const word of words) {
        if ((lines[lines.length - 1] + word).length > fits && lines[lines.length - 1]) lines.push('');
        lines[lines.length - 1] += word;
      }
      lines.forEach((text, j) => draw('text', {x: middle, y: bottom + 16 + 13 * j,
        'text-anchor': 'middle', class: 'tick', style: 'fill:#1b1f24'}, picture, text));
    });
    const legend = document.createElement('p');
    legend.className = 'facts';
    names.forEach((name, n) => {
      const ink = COLOURS[n % COLOURS.length], kind = MARKS[n % MARKS.length];
      const shift = (n - (names.length - 1) / 2) * Math.min(slot / (2 * names.length), 16);
      for (const [part, filled] of [['training', false], ['holdout', true]]) {
        const places = steps.map((step, k) => [LEFT + (k + 0.5) * slot + shift, step[part][name],
          step.added]).filter(([, value]) => value > 0);
        draw('path', {class: 'curve', stroke: ink, 'stroke-width': filled ? 2 : 1,
          'stroke-dasharray': filled ? 'none' : '3 4',
          d: places.map(([x, v], k) => `${k ? 'L' : 'M'}${x} ${y(v)}`).join('')}, picture);
        for (const [x, value, added] of places) {
          draw('title', {}, mark(picture, kind, x, y(value), ink, filled),
            `${titles[name] ? titles[name].title : name}, ${added}: ${number(value)} × floor `
            + `(${filled ? 'held out' : 'training'})`);
        }
      }
      const sample = draw('svg', {width: 18, height: 14, viewBox: '0 0 18 14',
        style: 'display:inline-block;width:18px;height:14px;vertical-align:-2px'}, null);
      mark(sample, kind, 9, 7, ink, true);
      legend.append(sample, ` ${titles[name] ? titles[name].title : name}   `);
    });
    const floor = draw('svg', {viewBox: '0 0 30 14',
      style: 'display:inline-block;width:30px;height:14px;vertical-align:-2px'}, null);
    draw('path', {d: 'M0 7H30', stroke: '#000', 'stroke-width': 1.5, 'stroke-dasharray': '6 4'},
      floor);
    legend.append(floor, ' noise floor: a perfect model');
    element.append(legend);
  }

  return {show};
})();
