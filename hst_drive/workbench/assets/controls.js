// Copyright 2026 hst_drive contributors
// SPDX-License-Identifier: Apache-2.0
// Switches and sliders of the effects, made from the catalogue.
'use strict';

const Controls = (() => {
  function make(tag, attributes = {}, ...content) {
    const node = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) {
      if (name in node && typeof value !== 'string') node[name] = value;
      else node.setAttribute(name, value);
    }
    node.append(...content);
    return node;
  }

  // A slider's way from 0 to 1: finer near zero, where most effects live.
  function way({low, high}) {
    if (low > 0 && high / low > 30) {
      return [(value) => Math.log(value / low) / Math.log(high / low),
        (place) => low * (high / low) ** place];
    }
    if (low > 0) {
      return [(value) => (value - low) / (high - low), (place) => low + place * (high - low)];
    }
    const most = Math.max(Math.abs(low), Math.abs(high));
    const first = Math.cbrt(low / most), last = Math.cbrt(high / most);
    return [(value) => (Math.cbrt(value / most) - first) / (last - first),
      (place) => most * (first + place * (last - first)) ** 3];
  }

  const short = (value) => Number(value.toPrecision(4));

  class Effects {
    // change(model, label) is called with the new model after each change of the user's.
    constructor(element, effects, change) {
      this.element = element;
      this.effects = effects;
      this.change = change;
      this.rows = new Map();
      this.locked = new Set();
      this.model = {effects: {}, factors: {}};
      const groups = new Map();
      for (const effect of effects) {
        if (!groups.has(effect.enters)) groups.set(effect.enters, []);
        groups.get(effect.enters).push(effect);
      }
      for (const [enters, members] of groups) {
        element.append(make('fieldset', {}, make('legend', {}, `enters: ${enters}`),
          ...members.map((effect) => this.row(effect))));
      }
    }

    row(effect) {
      const toggle = make('input', {type: 'checkbox', role: 'switch', id: `switch-${effect.id}`});
      const sizes = make('div', {class: 'sizes'});
      const row = make('div', {class: 'effect', 'data-id': effect.id},
        make('label', {}, toggle, make('b', {}, effect.id.replaceAll('_', ' '))), sizes,
        make('details', {}, make('summary', {}, 'what it is'),
          make('p', {}, `${effect.title}.`), make('p', {class: 'equation'}, effect.equation),
          make('p', {}, effect.telltale), make('p', {class: 'source'}, effect.source)));
      toggle.addEventListener('change', () => this.toggle(effect.id, toggle.checked));
      this.rows.set(effect.id, {effect, row, toggle, sizes, made: null});
      return row;
    }

    toggle(id, on) {
      const effects = {...this.model.effects};
      if (on) {
        effects[id] = Object.fromEntries(this.rows.get(id).effect.parameters.map((entry) =>
          [entry.name, entry.typical]));
      } else {
        delete effects[id];
      }
      this.change({...this.model, effects}, on ? `+ ${id}` : `− ${id}`);
    }

    set(id, name, value) {
      const effects = {...this.model.effects, [id]: {...this.model.effects[id], [name]: value}};
      this.change({...this.model, effects}, `${id}: ${name}`);
    }

    parameter(id, entry) {
      const [toPlace, toValue] = way(entry);
      const label = `${id.replaceAll('_', ' ')}: ${entry.name}`;
      const unit = entry.unit === '1' ? '' : entry.unit;
      const slider = make('input', {type: 'range', min: '0', max: '1', step: '0.002',
        'aria-label': `${label}, slider`});
      const number = make('input', {type: 'number', step: 'any',
        'aria-label': unit ? `${label} [${unit}]` : label, title: entry.meaning,
        min: String(short(entry.low * entry.per)), max: String(short(entry.high * entry.per))});
      const lock = make('input', {type: 'checkbox', 'aria-label': `lock ${label}`,
        title: entry.fixed ? 'chosen, never fitted' : 'a fit leaves it as it is'});
      lock.disabled = entry.fixed;
      lock.addEventListener('change', () => {
        const key = `${id}\n${entry.name}`;
        if (lock.checked) this.locked.add(key); else this.locked.delete(key);
      });
      slider.addEventListener('input', () => this.set(id, entry.name,
        short(toValue(Number(slider.value)))));
      number.addEventListener('change', () => {
        if (number.value.trim() !== '' && Number.isFinite(number.valueAsNumber)) {
          this.set(id, entry.name, number.valueAsNumber / entry.per);
        }
      });
      const show = (value) => {
        slider.value = String(toPlace(Math.min(Math.max(value, entry.low), entry.high)));
        slider.setAttribute('aria-valuetext', `${short(value * entry.per)} ${unit}`);
        if (document.activeElement !== number || number.valueAsNumber / entry.per !== value) {
          number.value = String(short(value * entry.per));
        }
        lock.checked = entry.fixed || this.locked.has(`${id}\n${entry.name}`);
      };
      const box = make('div', {class: 'parameter', title: entry.meaning},
        make('span', {}, entry.name), make('span', {}, number, ` ${unit}`), slider,
        make('label', {}, lock, ' lock'),
        make('span', {class: 'limits'}, `${short(entry.low * entry.per)} to `
          + `${short(entry.high * entry.per)} ${unit}${entry.fixed ? ', chosen, not fitted' : ''}`));
      return {box, show};
    }

    show(model) {
      this.model = model;
      for (const [id, entry] of this.rows) {
        const values = model.effects[id];
        entry.toggle.checked = Boolean(values);
        entry.row.classList.toggle('on', Boolean(values));
        if (!values) {
          entry.sizes.textContent = '';
          entry.made = null;
          continue;
        }
        if (!entry.made) {
          entry.made = entry.effect.parameters.map((parameter) => [parameter.name,
            this.parameter(id, parameter)]);
          entry.sizes.replaceChildren(...entry.made.map(([, made]) => made.box));
        }
        for (const [name, made] of entry.made) made.show(values[name]);
      }
    }

    find(text) {
      const wanted = text.toLowerCase();
      for (const {effect, row} of this.rows.values()) {
        const words = `${effect.id} ${effect.title} ${effect.telltale}`.toLowerCase();
        row.hidden = !words.replaceAll('_', ' ').includes(wanted) && !effect.id.includes(wanted);
      }
      for (const group of this.element.querySelectorAll('fieldset')) {
        group.hidden = !group.querySelector('.effect:not([hidden])');
      }
    }
  }

  return {make, Effects};
})();
