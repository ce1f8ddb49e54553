// Copyright 2026 hst_drive contributors
// SPDX-License-Identifier: Apache-2.0
// What all charts share: SVG elements, numbers, ticks, scales.
'use strict';

const Draw = (() => {
  const SPACE = 'http://www.w3.org/2000/svg';
  const LEFT = 56, RIGHT = 10;

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

  return {LEFT, RIGHT, unpack, draw, canvas, number, ticks, scale};
})();
