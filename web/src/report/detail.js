import { element } from './dom.js';
import { VERDICTS, fixed, length } from './words.js';
import { weakDrawing } from './weak.js';

/** Before and after on top of each other; the slider is the border between them. */
function comparison(image) {
  if (!image.pictures) return element('p', { class: 'hint' }, 'There is no picture of this photo.');
  const after = element('img', { class: 'after', src: image.pictures[2], alt: 'edges of the map over the photo, after' });
  const before = element('img', { class: 'before', src: image.pictures[1], alt: 'edges of the map over the photo, before' });
  const box = element('div', { class: 'compare' }, after, before, element('div', { class: 'border' }),
    element('span', { class: 'tag left' }, 'coarse pose'), element('span', { class: 'tag right' }, 'refined pose'));
  const slider = element('input', { type: 'range', min: 0, max: 100, step: 0.1, value: 50, 'aria-label': 'border between before and after' });
  const move = () => box.style.setProperty('--at', `${slider.value}%`);
  slider.addEventListener('input', move);
  move();
  box.append(slider);
  return box;
}

const figure = (name, ...values) => element('tr', {}, element('th', {}, name), ...values.map((value) => element('td', { class: 'n' }, value)));

function figures(image) {
  const pair = (name, before, after, show) => figure(name, show(before), show(after));
  const percent = (value) => (value === null ? '–' : `${fixed(100 * value, 0)} %`);
  const whole = (value) => String(value);
  const b = image.before, a = image.after, hb = image.held_out_before, ha = image.held_out_after;
  return element('table', { class: 'plain' },
    element('thead', {}, element('tr', {}, element('th', {}, ''), element('th', { class: 'n' }, 'before'), element('th', { class: 'n' }, 'after'))),
    element('tbody', {},
      pair('held-out residual, median px', hb.median_px, ha.median_px, fixed),
      pair('held-out residual, RMS px', hb.rms_px, ha.rms_px, fixed),
      pair('held-out edges that fit', hb.inlier_share, ha.inlier_share, percent),
      pair('held-out log likelihood ratio', hb.log_ratio, ha.log_ratio, (value) => fixed(value, 0)),
      pair('all edges, median px', b.median_px, a.median_px, fixed),
      pair('matched samples', b.matches, a.matches, whole),
      pair('surface patches, median px', image.surfaces.matches ? image.surfaces.before_median_px : null,
        image.surfaces.matches ? image.surfaces.after_median_px : null, fixed)));
}

function facts(image) {
  const rows = [
    ['expected shift', image.matches ? `${fixed(image.predicted_shift_px)} px` : '–'],
    ['moved', image.moved_m ? `${length(image.moved_m)}, ${fixed(image.moved_deg)}°` : 'not at all'],
    ['place is known to', image.ellipse ? `${length(image.ellipse[0])} (one standard deviation, worst direction)` : '–'],
    ['map edges in view', String(image.map_edges)],
    ['patches shared with other photos', String(image.surfaces.matches)],
    ['sharpness', fixed(image.sharpness)],
  ];
  return element('table', { class: 'plain' }, element('tbody', {}, ...rows.map(([name, value]) => figure(name, value))));
}

export function showDetail(dialog, image, list) {
  const at = list.indexOf(image);
  const go = (step) => () => { if (list[at + step]) showDetail(dialog, list[at + step], list); };
  const head = element('header', {},
    element('button', { click: go(-1), disabled: at <= 0, 'aria-label': 'previous photo' }, '‹'),
    element('button', { click: go(1), disabled: at < 0 || at >= list.length - 1, 'aria-label': 'next photo' }, '›'),
    element('h2', {}, image.name),
    element('span', { class: `badge ${image.status}` }, VERDICTS[image.status].label),
    element('span', { class: 'hint' }, image.reason),
    element('button', { class: 'close', click: () => dialog.close(), 'aria-label': 'close' }, '×'));
  dialog.replaceChildren(head, comparison(image), element('div', { class: 'columns' }, figures(image), facts(image), weakDrawing(image)));
  dialog.onkeydown = (event) => {
    if (event.target.type === 'range') return;
    if (event.key === 'ArrowLeft') go(-1)();
    if (event.key === 'ArrowRight') go(1)();
  };
  if (!dialog.open) dialog.showModal();
}
