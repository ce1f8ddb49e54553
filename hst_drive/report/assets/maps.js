// Copyright 2026 hst_drive contributors
// SPDX-License-Identifier: Apache-2.0
// Where a model fails: maps over two variables, strips over one.
'use strict';

const Maps = (() => {
  const {LEFT, RIGHT, draw, canvas, number, ticks, scale} = Draw;
  const CIVIDIS = [[0, 34, 78], [53, 69, 108], [102, 105, 112], [148, 142, 119], [200, 184, 102],
    [254, 232, 56]];

  function colour(share) {
    const place = Math.min(Math.max(share, 0), 1) * (CIVIDIS.length - 1);
    const k = Math.min(Math.floor(place), CIVIDIS.length - 2), rest = place - k;
    return `rgb(${CIVIDIS[k].map((v, j) => Math.round(v + rest * (CIVIDIS[k + 1][j] - v)))})`;
  }

  // Error over the floor on a grid of two variables.
  function map(element, found, titles) {
    element.textContent = '';
    if (!found) {
      element.textContent = 'No map: pressure and speed were not recorded, or did not vary.';
      return;
    }
    const width = Math.max(element.clientWidth, 260), height = 330, bottom = height - 66;
    const name = (key) => `${titles[key].title} [${titles[key].unit}]`;
    const picture = canvas(element, width, height, `error over ${name(found.x)}, ${name(found.y)}`);
    const {xEdges, yEdges, cells} = found;
    const x = scale(xEdges[0], xEdges[xEdges.length - 1], LEFT, width - RIGHT);
    const y = scale(yEdges[0], yEdges[yEdges.length - 1], bottom, 22);
    const top = Math.max(2, ...cells.flat().filter((value) => value !== null));
    cells.forEach((row, j) => row.forEach((value, i) => {
      if (value === null) return;
      const cell = draw('rect', {x: x(xEdges[i]), y: y(yEdges[j + 1]), stroke: '#fff',
        'stroke-width': 0.5, width: x(xEdges[i + 1]) - x(xEdges[i]),
        height: y(yEdges[j]) - y(yEdges[j + 1]),
        fill: colour(Math.log(Math.max(value, 1)) / Math.log(top))}, picture);
      draw('title', {}, cell, `${number(value)} × floor at ${number(xEdges[i])} to `
        + `${number(xEdges[i + 1])} ${titles[found.x].unit}, ${number(yEdges[j])} to `
        + `${number(yEdges[j + 1])} ${titles[found.y].unit}`);
    }));
    for (const [value, text] of ticks(xEdges[0], xEdges[xEdges.length - 1], width / 90)) {
      draw('text', {class: 'tick', x: x(value), y: bottom + 15, 'text-anchor': 'middle'}, picture,
        text);
    }
    for (const [value, text] of ticks(yEdges[0], yEdges[yEdges.length - 1], 5)) {
      draw('text', {class: 'tick', x: LEFT - 6, y: y(value) + 4, 'text-anchor': 'end'}, picture,
        text);
    }
    draw('path', {class: 'axis', d: `M${LEFT} 22V${bottom}H${width - RIGHT}`}, picture);
    draw('text', {class: 'tick', x: width - RIGHT, y: bottom + 30, 'text-anchor': 'end'}, picture,
      name(found.x));
    draw('text', {class: 'tick', x: 4, y: 13}, picture, name(found.y));
    const bar = Math.min(width - LEFT - RIGHT, 240);
    for (let k = 0; k < 40; k++) {
      draw('rect', {x: LEFT + k * bar / 40, y: height - 26, width: bar / 40 + 0.5, height: 10,
        fill: colour(k / 39)}, picture);
    }
    draw('text', {class: 'tick', x: LEFT, y: height - 4}, picture, '1 × floor');
    draw('text', {class: 'tick', x: LEFT + bar, y: height - 4, 'text-anchor': 'end'}, picture,
      `${number(top)} × floor`);
  }

  // Mean error and its scatter in strips of one variable after the other.
  function strips(element, found, signal, titles) {
    element.textContent = '';
    const names = Object.keys(found.over);
    if (!names.length) {
      element.textContent = 'Temperature, commands and torque did not vary, or were not recorded.';
    }
    const width = Math.max(element.clientWidth, 260);
    for (const name of names) {
      const {x: places, mean, spread} = found.over[name];
      const label = `${titles[name].title} [${titles[name].unit}]`;
      const picture = canvas(element, width, 130, `error over ${label}`);
      const most = Math.max(found.floor * 1.3, ...mean.map((v, k) => Math.abs(v) + spread[k]));
      const x = scale(places[0], places[places.length - 1], LEFT + 8, width - RIGHT - 8);
      const y = scale(-most, most, 96, 22);
      draw('rect', {class: 'band', x: LEFT, width: width - LEFT - RIGHT, y: y(found.floor),
        height: y(-found.floor) - y(found.floor)}, picture);
      for (const [value, text] of ticks(-most, most, 4)) {
        draw('text', {class: 'tick', x: LEFT - 6, y: y(value) + 4, 'text-anchor': 'end'}, picture,
          text);
      }
      draw('path', {class: 'grid', d: `M${LEFT} ${y(0)}H${width - RIGHT}`}, picture);
      draw('path', {class: 'axis', d: `M${LEFT} 22V96H${width - RIGHT}`}, picture);
      draw('path', {class: 'curve error',
        d: mean.map((v, k) => `${k ? 'L' : 'M'}${x(places[k])} ${y(v)}`).join('')}, picture);
      mean.forEach((v, k) => {
        draw('path', {class: 'curve error',
          d: `M${x(places[k])} ${y(v - spread[k])}V${y(v + spread[k])}`}, picture);
        const dot = draw('circle', {cx: x(places[k]), cy: y(v), r: 3.5, fill: '#0072B2'}, picture);
        draw('title', {}, dot, `${number(v)} ± ${number(spread[k])} ${titles[signal].unit} at `
          + `${number(places[k])} ${titles[name].unit}`);
      });
      for (const [value, text] of ticks(places[0], places[places.length - 1], width / 90)) {
        draw('text', {class: 'tick', x: x(value), y: 110, 'text-anchor': 'middle'}, picture, text);
      }
      draw('text', {class: 'tick', x: width - RIGHT, y: 125, 'text-anchor': 'end'}, picture, label);
      draw('text', {class: 'tick', x: 4, y: 13}, picture,
        `mean error of ${titles[signal].title} [${titles[signal].unit}]`);
    }
  }

  return {map, strips};
})();
