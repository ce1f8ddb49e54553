// Copyright 2026 hst_drive contributors
// SPDX-License-Identifier: Apache-2.0
// Charts in SVG: curves over time with one cursor and one zoom for all, maps, strips, the ladder.
'use strict';

const Charts = (() => {
  const SPACE = 'http://www.w3.org/2000/svg';
  const LEFT = 56, RIGHT = 10;
  // Okabe and Ito's colours, told apart by colour-blind readers; marks differ as well.
  const COLOURS = ['#0072B2', '#D55E00', '#009E73', '#CC79A7', '#000000', '#56B4E9', '#E69F00',
    '#5b3fa0', '#7a7a7a'];
  const MARKS = ['circle', 'square', 'triangle', 'diamond', 'cross', 'down'];
  const CIVIDIS = [[0, 34, 78], [53, 69, 108], [102, 105, 112], [148, 142, 119], [200, 184, 102],
    [254, 232, 56]];

  function unpack(text) {
    const raw = atob(text), bytes = new Uint8Array(raw.length);
    for (let k = 0; k < raw.length; k++) bytes[k] = raw.charCodeAt(k);
    return new Float32Array(bytes.buffer);
  }

  function draw(tag, attributes, parent, text) {
    const node = document.createElementNS(SPACE, tag);
    for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
    if (text !== undefined) node.textContent = text;
    if (parent) parent.appendChild(node);
    return node;
  }

  function canvas(element, width, height, label) {
    const picture = draw('svg', {viewBox: `0 0 ${width} ${height}`, role: 'img'}, null);
    draw('title', {}, picture, label);
    element.appendChild(picture);
    return picture;
  }

  function number(value, digits = 3) {
    if (value === null || value === undefined || Number.isNaN(value)) return '–';
    if (value === 0) return '0';
    const size = Math.abs(value);
    const text = size >= 1e5 || size < 1e-3 ? value.toExponential(digits - 1)
      : size >= 10 ** (digits - 1) ? value.toFixed(size < 1000 && digits > 3 ? 1 : 0)
        : value.toPrecision(digits);
    return text.replace('-', '−');
  }

  function ticks(low, high, count) {
    const raw = (high - low) / Math.max(count, 1) || 1;
    const power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((k) => k * power).find((k) => k >= raw * 0.7);
    const found = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) {
      found.push(Math.abs(k * step) < 1e-12 ? 0 : k * step);
    }
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    return found.map((value) => [value, value.toFixed(Math.min(digits, 6)).replace('-', '−')]);
  }

  function scale(low, high, from, to) {
    const span = high - low || 1;
    return (value) => from + (value - low) / span * (to - from);
  }

  function range(columns, first, last) {
    let low = Infinity, high = -Infinity;
    for (const values of columns) {
      for (let k = first; k < last; k++) {
        const value = values[k];
        if (value < low) low = value;
        if (value > high) high = value;
      }
    }
    if (!(low <= high)) return [0, 1];
    const pad = 0.05 * (high - low) || 0.05 * Math.abs(high) || 1;
    return [low - pad, high + pad];
  }

  // At most two points per pixel: the least and the greatest value of what falls on it.
  function line(time, values, first, last, x, y) {
    const parts = [];
    let open = false;
    const point = (t, value) => {
      if (!Number.isFinite(value)) { open = false; return; }
      parts.push(`${open ? 'L' : 'M'}${x(t).toFixed(1)} ${y(value).toFixed(1)}`);
      open = true;
    };
    const columns = Math.max(x(time[last - 1]) - x(time[first]), 1);
    if (last - first <= 2 * columns) {
      for (let k = first; k < last; k++) point(time[k], values[k]);
      return parts.join('');
    }
    let k = first;
    while (k < last) {
      const column = Math.floor(x(time[k]));
      let least = k, most = k;
      for (; k < last && Math.floor(x(time[k])) === column; k++) {
        if (values[k] < values[least] || Number.isNaN(values[least])) least = k;
        if (values[k] > values[most] || Number.isNaN(values[most])) most = k;
      }
      for (const at of least < most ? [least, most] : [most, least]) point(time[at], values[at]);
    }
    return parts.join('');
  }

  function search(time, value) {
    let low = 0, high = time.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (time[middle] < value) low = middle + 1; else high = middle;
    }
    return low;
  }

  // Curves of one log: a plot per signal, measured and model above, the error below.
  class TimePlots {
    constructor(element, titles) {
      this.element = element;
      this.titles = titles;
      this.view = null;
      this.cursor = null;
      element.tabIndex = 0;
      element.addEventListener('keydown', (event) => this.key(event));
      new ResizeObserver(() => this.redraw()).observe(element);
    }

    // log: time, measured, inputs; curves: model, error, floor, ratio; other: model of before.
    show(log, curves, other) {
      const fresh = !this.log || this.log.name !== log.name;
      this.log = log;
      this.curves = curves;
      this.other = other || null;
      if (fresh) { this.view = null; this.cursor = null; }
      this.redraw();
    }

    get full() { return [this.log.time[0], this.log.time[this.log.time.length - 1]]; }

    zoom(low, high) {
      const [first, last] = this.full;
      const least = (last - first) * 8 / this.log.time.length;
      const span = Math.min(Math.max(high - low, least), last - first);
      const begin = Math.min(Math.max(low, first), last - span);
      this.view = span >= last - first ? null : [begin, begin + span];
      this.redraw();
    }

    zoomBy(factor) {
      const [low, high] = this.view || this.full;
      const at = this.cursor === null || this.cursor < low || this.cursor > high
        ? (low + high) / 2 : this.cursor;
      this.zoom(at - (at - low) * factor, at + (high - at) * factor);
    }

    key(event) {
      if (event.target !== this.element) return;
      const [low, high] = this.view || this.full, span = high - low;
      const at = this.cursor === null ? (low + high) / 2 : this.cursor;
      const step = span / (event.shiftKey ? 20 : 200);
      const actions = {
        ArrowLeft: () => this.point(Math.max(at - step, low)),
        ArrowRight: () => this.point(Math.min(at + step, high)),
        '+': () => this.zoomBy(0.5), '=': () => this.zoomBy(0.5), '-': () => this.zoomBy(2),
        0: () => { this.view = null; this.redraw(); },
        Home: () => this.zoom(this.full[0], this.full[0] + span),
        End: () => this.zoom(this.full[1] - span, this.full[1]),
        PageUp: () => this.zoom(low - span / 2, high - span / 2),
        PageDown: () => this.zoom(low + span / 2, high + span / 2),
        Escape: () => this.point(null),
      };
      if (actions[event.key]) { actions[event.key](); event.preventDefault(); }
    }

    redraw() {
      if (!this.log || this.pending) return;
      this.pending = true;
      requestAnimationFrame(() => { this.pending = false; this.paint(); });
    }

    paint() {
      const width = Math.max(this.element.clientWidth, 280);
      const [low, high] = this.view || this.full;
      const {time} = this.log;
      const first = Math.max(search(time, low) - 1, 0);
      const last = Math.min(search(time, high) + 2, time.length);
      this.element.textContent = '';
      this.plots = [];
      const x = scale(low, high, LEFT, width - RIGHT);
      const frame = {width, low, high, first, last, x};
      for (const name of Object.keys(this.log.measured)) this.signal(name, frame);
      for (const name of Object.keys(this.log.inputs)) this.input(name, frame);
      this.point(this.cursor);
    }

    signal(name, frame) {
      const {time} = this.log, {first, last, x, width} = frame;
      const measured = this.log.measured[name], model = this.curves.model[name];
      const error = this.curves.error[name], floor = this.curves.floor[name];
      const {title, unit} = this.titles[name];
      const picture = canvas(this.element, width, 262, `${title}: measured, model and error`);
      const shown = [measured, model];
      const other = this.other && this.other.model[name];
      if (other) shown.push(other);
      const upper = this.box(picture, frame, 36, 166, range(shown, first, last), 4);
      let most = 2.2 * floor || 1e-9;
      for (let k = first; k < last; k++) if (Math.abs(error[k]) > most) most = Math.abs(error[k]);
      const lower = this.box(picture, frame, 176, 242, [-1.06 * most, 1.06 * most], 3);
      draw('rect', {class: 'band', x: LEFT, width: width - RIGHT - LEFT, y: lower(2 * floor),
        height: Math.max(lower(-2 * floor) - lower(2 * floor), 0)}, picture);
      for (const [begin, end] of this.log.leftOut || []) {
        const [from, to] = [begin, end].map((t) => x(Math.min(Math.max(t, frame.low), frame.high)));
        draw('rect', {class: 'left-out', x: from, width: to - from, y: 36, height: 206}, picture);
      }
      this.timeAxis(picture, frame, 242);
      const curve = (kind, values, y) => draw('path', {class: `curve ${kind}`,
        d: line(time, values, first, last, x, y)}, picture);
      curve('measured', measured, upper);
      if (other) curve('other', other, upper);
      curve('model', model, upper);
      curve('error', error, lower);
      const size = width < 360 ? 'font-size: 10px' : '';
      draw('text', {class: 'label', x: width < 480 ? 2 : LEFT, y: 13, style: size}, picture,
        `${title} [${unit}]`);
      draw('text', {class: 'label', x: width - RIGHT, y: 13, 'text-anchor': 'end', style: size},
        picture, `${width < 480 ? '' : 'error '}${number(this.curves.ratio[name])} × floor`);
      this.plots.push(this.pointer(picture, frame, 36, 242, (k) => {
        return `measured ${number(measured[k], 4)}   model ${number(model[k], 4)}`
          + `   error ${number(error[k])}`;
      }));
    }

    input(name, frame) {
      const {time} = this.log, {first, last, x, width} = frame;
      const values = this.log.inputs[name], {title, unit} = this.titles[name];
      const picture = canvas(this.element, width, 112, `${title} over time`);
      const y = this.box(picture, frame, 36, 92, range([values], first, last), 3);
      this.timeAxis(picture, frame, 92);
      draw('path', {class: 'curve measured', d: line(time, values, first, last, x, y)}, picture);
      draw('text', {class: 'label', x: LEFT, y: 13}, picture, `input: ${title} [${unit}]`);
      this.plots.push(this.pointer(picture, frame, 36, 92, (k) => number(values[k], 4)));
    }

    box(picture, frame, top, bottom, [low, high], count) {
      const y = scale(low, high, bottom, top);
      for (const [value, text] of ticks(low, high, count)) {
        draw('path', {class: 'grid', d: `M${LEFT} ${y(value)}H${frame.width - RIGHT}`}, picture);
        draw('text', {class: 'tick', x: LEFT - 6, y: y(value) + 4, 'text-anchor': 'end'}, picture,
          text);
      }
      draw('path', {class: 'axis', d: `M${LEFT} ${top}V${bottom}`}, picture);
      return y;
    }

    timeAxis(picture, frame, bottom) {
      const {x, low, high, width} = frame;
      draw('path', {class: 'axis', d: `M${LEFT} ${bottom}H${width - RIGHT}`}, picture);
      for (const [value, text] of ticks(low, high, width / 110)) {
        draw('text', {class: 'tick', x: Math.min(x(value), width - RIGHT - 6), y: bottom + 14,
          'text-anchor': 'middle'}, picture, text + (value === 0 ? ' s' : ''));
      }
    }

    pointer(picture, frame, top, bottom, says) {
      const cursor = draw('path', {class: 'cursor', d: '', visibility: 'hidden'}, picture);
      const words = draw('text', {class: 'tick', x: LEFT, y: 29}, picture, '');
      const brush = draw('rect', {class: 'brush', y: top, height: bottom - top, width: 0}, picture);
      const surface = draw('rect', {class: 'surface', x: LEFT, y: top,
        width: frame.width - LEFT - RIGHT, height: bottom - top}, picture);
      let from = null;
      const at = (event) => {
        const box = picture.getBoundingClientRect();
        const place = (event.clientX - box.left) * frame.width / box.width;
        const share = (place - LEFT) / (frame.width - LEFT - RIGHT);
        return frame.low + Math.min(Math.max(share, 0), 1) * (frame.high - frame.low);
      };
      surface.addEventListener('pointerdown', (event) => {
        if (event.button === 0) { from = at(event); surface.setPointerCapture(event.pointerId); }
      });
      surface.addEventListener('pointermove', (event) => {
        const now = at(event);
        this.point(now);
        if (from !== null) {
          const [low, high] = [frame.x(Math.min(from, now)), frame.x(Math.max(from, now))];
          brush.setAttribute('x', low);
          brush.setAttribute('width', high - low);
        }
      });
      surface.addEventListener('pointerup', (event) => {
        const now = at(event), begin = from;
        from = null;
        brush.setAttribute('width', 0);
        if (begin !== null && Math.abs(frame.x(now) - frame.x(begin)) > 6) {
          this.zoom(Math.min(begin, now), Math.max(begin, now));
        }
      });
      surface.addEventListener('pointercancel', () => {
        from = null;
        brush.setAttribute('width', 0);
      });
      surface.addEventListener('dblclick', () => { this.view = null; this.redraw(); });
      return (time, index) => {
        cursor.setAttribute('visibility', time === null ? 'hidden' : 'visible');
        if (time !== null) cursor.setAttribute('d', `M${frame.x(time)} ${top}V${bottom}`);
        words.textContent = time === null ? '' : `${number(time, 4)} s:   ${says(index)}`;
      };
    }

    point(time) {
      this.cursor = time;
      const [low, high] = this.view || this.full;
      const shown = time === null || time < low || time > high ? null : time;
      const index = shown === null ? 0 : Math.min(search(this.log.time, shown),
        this.log.time.length - 1);
      for (const plot of this.plots || []) plot(shown, index);
    }
  }

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
      for (const [value, text] of ticks(-most, most, 3)) {
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
  function ladder(element, steps, titles) {
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

  return {unpack, number, TimePlots, map, strips, ladder, draw, COLOURS};
})();
