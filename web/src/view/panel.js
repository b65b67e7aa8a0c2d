import { checkbox, element } from '../report/dom.js';
import { count, shiftColor } from '../report/words.js';

function slider(label, min, max, step, value, change) {
  const input = element('input', { type: 'range', min, max, step, input: () => change(Number(input.value)) });
  input.value = value;
  return element('label', { class: 'row' }, element('span', {}, label), input);
}

function poseSwitch(cameras) {
  const buttons = ['coarse', 'refined'].map((kind) => element('button', { 'data-kind': kind, click: () => cameras.use(kind) }, `${kind} poses`));
  const mark = () => buttons.forEach((button) => button.setAttribute('aria-pressed', button.dataset.kind === cameras.kind));
  cameras.onChange(mark);
  mark();
  return element('div', { class: 'switch' }, ...buttons);
}

// A cloud that ends this close above the cameras has a ceiling, which would hide everything from above; metres.
const CEILING_M = 6;
const ABOVE_CAMERAS_M = 0.4;

/** A slider that hides what is high, so that one looks into rooms; set once the cloud's height is known. */
function cutSlider(stage, cloud, cameras, photo) {
  const state = { height: null, known: false };
  const row = slider('cut above', 0, 1, 0.005, 1, (share) => { apply(share); });
  const input = row.querySelector('input');
  const low = () => cameras.top - 2.5;
  function apply(share) {
    state.height = share >= 1 ? null : low() + share * (cloud.top + 0.1 - low());
    if (!photo.shown) stage.cutAbove(state.height);
  }
  return {
    row,
    restore: () => stage.cutAbove(state.height),
    update() {
      if (state.known || cloud.top === null) return;
      state.known = true;
      if (cloud.top - cameras.top > CEILING_M) return;
      input.value = Math.min(1, (cameras.top + ABOVE_CAMERAS_M - low()) / (cloud.top + 0.1 - low()));
      apply(Number(input.value));
    },
  };
}

/** Everything that can be set. */
export function makePanel({ view, stage, cloud, cameras, photo, measure }) {
  const ramp = Array.from({ length: 9 }, (_, i) => shiftColor((i * view.limit_px) / 8, view.limit_px));
  const shown = { cameras: true, trail: true };
  const showLines = () => { cameras.shown = shown.cameras && !photo.shown; cameras.trailShown = shown.trail && !photo.shown; };
  const cut = cutSlider(stage, cloud, cameras, photo);
  photo.onHide = () => { showLines(); cut.restore(); };
  const measuring = element('button', { id: 'measure', click: () => (measure.active ? measure.stop() : measure.start()) }, 'measure a distance');
  const hint = element('p', { class: 'muted' });
  measure.onChange = () => {
    measuring.setAttribute('aria-pressed', measure.active);
    hint.textContent = measure.active ? 'Click two points. Esc ends.' : '';
  };
  const list = element('datalist', { id: 'names' }, ...view.images.map((image) => element('option', { value: image.name })));
  const search = element('input', { type: 'search', list: 'names', placeholder: 'go to a photo', 'aria-label': 'go to a photo',
    change: () => { const index = view.images.findIndex((image) => image.name === search.value); if (index >= 0) photo.show(index); } });
  document.getElementById('panel').append(
    element('h1', {}, 'CP+ ', element('span', {}, 'viewer')),
    element('p', { class: 'muted' }, `${count(view.points, 'point')}, ${count(view.images.length, 'photo')}`),
    poseSwitch(cameras),
    element('div', { class: 'ramp' }, '0', element('i', { style: `background:linear-gradient(90deg,${ramp.join(',')})` }), `${view.limit_px} px expected shift`),
    search, list,
    checkbox('cameras', true, (on) => { shown.cameras = on; showLines(); }),
    checkbox('from coarse to refined', true, (on) => { shown.trail = on; showLines(); }),
    checkbox('cloud', true, (on) => { cloud.shown = on; }),
    cut.row,
    slider('size of cameras', 0.05, 2, 0.05, cameras.size, (size) => { cameras.size = size; }),
    slider('size of points', 1, 6, 0.5, 2, (size) => { cloud.pointSize = size; }),
    slider('detail', -8, -1, 0.25, -2.5, (px) => { cloud.detail = -px; }),
    element('div', { class: 'buttons' }, measuring, element('button', { click: () => { photo.hide(); cameras.frame(); } }, 'show all')),
    hint,
    element('p', { class: 'muted small' }, 'Drag turns, right drag moves, wheel zooms. Click a camera for its photo: drag looks around, ← → next, R coarse or refined, Esc back.'));
  const status = document.getElementById('status');
  return {
    update() {
      cut.update();
      status.textContent = `${cloud.numDrawn.toLocaleString('en')} points drawn${cloud.isLoading ? ', loading…' : ''}`;
    },
  };
}
