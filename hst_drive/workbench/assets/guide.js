// Copyright 2026 hst_drive contributors
// SPDX-License-Identifier: Apache-2.0
// The first visit: here it fails, this is where, try these, see the error fall.
'use strict';

const Guide = (() => {
  const {make} = Controls;
  const STEPS = [
    ['1. Here it fails', 'This is a log of a minute of a drive, and one more that is held out. '
      + 'The model replays what was commanded. The error of the hydromotor speed is many times '
      + 'what a perfect model would show: something is missing in the model.', 'errors'],
    ['2. This is where', 'The map shows the error over pressure and speed. It grows with the '
      + 'pressure, at any speed, and it goes with the load. So look for something that costs speed '
      + 'the more, the higher the pressure.', 'where'],
    ['3. Try these', 'Switch one on, look at the column “held out”, switch it off again if it does '
      + 'not help: friction, a leaking pump, or a leaking hydromotor? One of them mends the speed '
      + 'but spoils the flow.', 'errors', ['bearing_friction', 'pump_leakage', 'motor_leakage']],
    ['4. Fit its size', 'With the right one on, let the tool fit its size. The training error and '
      + 'the held-out error fall together: that is physics, not fitted noise.', 'errors', [], 'fit'],
    ['5. See the error fall', 'All signals stand at the floor, and your steps are drawn below. '
      + 'Now let the tool do it alone: start over and ask what is missing. It tries all effects, '
      + 'and says how sure it is. Then save the model as a rig file. With logs of your own: '
      + 'hst-drive workbench LOG...', 'ladder', [], 'diagnose'],
  ];

  function start(element, toggle) {
    let place = 0;
    const show = () => {
      const [title, text, target, effects = [], press] = STEPS[place];
      const button = (words, act, more = {}) => {
        const made = make('button', {type: 'button', ...more}, words);
        made.addEventListener('click', act);
        return made;
      };
      const buttons = make('p', {class: 'controls'});
      buttons.append(
        button('Back', () => { place -= 1; show(); }, {disabled: place === 0}),
        button('Next', () => { place += 1; show(); }, {disabled: place === STEPS.length - 1}),
        button('Show it', () => document.getElementById(target).scrollIntoView()),
        ...effects.map((id) => button(`switch ${id.replaceAll('_', ' ')}`, () => toggle(id))),
        ...(press ? [button(document.getElementById(press).textContent,
          () => document.getElementById(press).click())] : []),
        button('Close the guide', () => { element.hidden = true; }));
      element.replaceChildren(make('h2', {}, title), make('p', {}, text), buttons);
      element.hidden = false;
    };
    show();
  }

  return {start};
})();
