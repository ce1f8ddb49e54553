// Copyright 2026 hst_drive contributors
// SPDX-License-Identifier: Apache-2.0
// Curves of a log over time, with one cursor and one zoom for all plots.
'use strict';

const TimePlots = (() => {
  const {LEFT, RIGHT, draw, canvas, number, ticks, scale} = Draw;

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

  return TimePlots;
})();
