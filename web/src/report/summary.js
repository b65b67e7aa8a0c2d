import { element } from './dom.js';
import { VERDICTS, VERDICT_NAMES, count, fixed, isPlaced, length, median, shiftLimit } from './words.js';

// docs/refine.md, "Verdict of the joint solve": share of accepted photos within 3 px of the best pose on the map.
const PRECISION = { 0.6: 100, 1: 98, 1.4: 97, 2: 94, 3: 87 };

function cards(report) {
  const number = (status) => report.images.filter((image) => image.status === status).length;
  const shown = [...VERDICT_NAMES].reverse().filter((status) => status === 'refined' || number(status) > 0);
  return element('div', { class: 'cards' }, ...shown.map((status) =>
    element('div', { class: `card ${status}` }, element('b', {}, number(status).toLocaleString('en')),
      element('span', {}, VERDICTS[status].label))));
}

function sureText(report, placed) {
  const shifts = placed.map((image) => image.predicted_shift_px).filter((shift) => shift !== null);
  if (placed.length === 0) return 'No photo could be placed better than by its coarse pose.';
  if (shifts.length === 0) return 'Each photo was placed on its own: how far off it may be is not known.';
  const limit = shiftLimit(report);
  let text = `Half of the placed photos are expected to be off by at most ${fixed(median(shifts))} px, the least sure by `
    + `${fixed(Math.max(...shifts))} px. `;
  if (PRECISION[limit]) {
    text += `In scenes with known truth ${PRECISION[limit]} of 100 photos that were accepted up to ${limit} px were `
      + 'within 3 px of the right place; real errors were up to twice the expected ones.';
  }
  return text;
}

function fitText(placed) {
  const before = median(placed.map((image) => image.held_out_before.inlier_share));
  const after = median(placed.map((image) => image.held_out_after.inlier_share));
  if (before === null || after === null) return null;
  return `Checked with edges that took no part in the solution: before, ${fixed(100 * before, 0)} % of the map's edges lay `
    + `on an edge of the photo, now ${fixed(100 * after, 0)} % (median of the placed photos).`;
}

function movedText(placed) {
  const moved = placed.filter((image) => image.moved_m !== undefined);
  if (moved.length === 0) return null;
  return `The placed photos moved by ${length(median(moved.map((image) => image.moved_m)))} and turned by `
    + `${fixed(median(moved.map((image) => image.moved_deg)))}° (median).`;
}

function reasonList(report) {
  const groups = new Map();
  for (const image of report.images.filter((candidate) => !isPlaced(candidate))) {
    // What comes after a path is the reason of an unreadable file; the path differs from photo to photo.
    const reason = image.status === 'unreadable' ? image.reason.split(': ').slice(1).join(': ') : image.reason;
    groups.set(reason, [...(groups.get(reason) ?? []), image]);
  }
  if (groups.size === 0) return null;
  const sorted = [...groups].sort((a, b) => b[1].length - a[1].length);
  return element('ul', {}, ...sorted.map(([reason, images]) => element('li', {},
    element('b', {}, count(images.length, 'photo')), ` – ${reason || 'no reason given'}`)));
}

function weakText(placed) {
  const weak = placed.filter((image) => image.weak_directions.length > 0);
  if (weak.length === 0) return null;
  return `${count(weak.length, 'placed photo')} ${weak.length === 1 ? 'sees' : 'see'} too little structure in some direction; there the `
    + 'other photos and the coarse pose decide.';
}

const AXES = ['x (right)', 'y (down)', 'z (forward)'];
const degrees = (radians) => (radians * 180) / Math.PI;
const norm = (v) => Math.hypot(...v);

/** The clock's error is only known where it is known better than was assumed before. */
function clockText(shared, report) {
  const assumed = Number(report.options['joint_solve.prior.time_offset_sigma_s'] ?? report.options['joint_solve.time_offset_sigma_s'] ?? 0.05);
  if (shared.time_offset_sigma_s > 0.7 * assumed) return ' Its clock cannot be judged from these photos.';
  const sure = Math.abs(shared.time_offset_s) > 3 * shared.time_offset_sigma_s;
  return ` Its clock is off by ${fixed(shared.time_offset_s * 1000, 1)} ± ${fixed(shared.time_offset_sigma_s * 1000, 1)} ms`
    + `${sure ? '' : ', which is not more than chance'}.`;
}

function rigText(camera, shared, report) {
  const turn = degrees(norm(shared.extrinsic.slice(0, 3)));
  const shift = norm(shared.extrinsic.slice(3));
  return `Camera ${camera}: the mounting (extrinsic) that the coarse poses were made with is off by ${fixed(turn)}° and `
    + `${length(shift)}, found from ${count(shared.images, 'photo')}.${clockText(shared, report)}`;
}

function rigTable(shared) {
  const row = (name, value, sigma, unit, digits) => element('tr', {}, element('td', {}, name),
    element('td', { class: 'n' }, `${fixed(value, digits)} ± ${fixed(sigma, digits)} ${unit}`),
    element('td', { class: 'muted' }, Math.abs(value) > 3 * sigma ? '' : 'not more than chance'));
  const rows = AXES.map((axis, i) =>
    row(`turned about ${axis}`, degrees(shared.extrinsic[i]), degrees(shared.extrinsic_sigmas[i]), '°', 3));
  rows.push(...AXES.map((axis, i) =>
    row(`moved along ${axis}`, 100 * shared.extrinsic[i + 3], 100 * shared.extrinsic_sigmas[i + 3], 'cm', 2)));
  if (shared.time_offset_sigma_s > 0) {
    rows.push(row('clock', 1000 * shared.time_offset_s, 1000 * shared.time_offset_sigma_s, 'ms', 1));
  }
  return element('details', {}, element('summary', {}, 'each axis, with one standard deviation'),
    element('table', { class: 'plain' }, element('tbody', {}, ...rows)));
}

export function showSummary(section, report) {
  const placed = report.images.filter(isPlaced);
  const share = report.images.length ? placed.length / report.images.length : 0;
  const mood = share >= 0.9 ? 'good' : share >= 0.5 ? 'fair' : 'poor';
  const paragraphs = [sureText(report, placed), fitText(placed), movedText(placed), weakText(placed)];
  section.append(
    element('h1', { class: mood }, `${placed.length.toLocaleString('en')} of ${count(report.images.length, 'photo')} `
      + `${placed.length === 1 ? 'is' : 'are'} placed on the map`),
    element('p', { class: 'where' }, report.title),
    cards(report),
    ...paragraphs.filter(Boolean).map((text) => element('p', {}, text)));
  const reasons = reasonList(report);
  if (reasons) section.append(element('h3', {}, 'Not placed, and why'), reasons);
  const rigs = Object.entries(report.shared);
  if (rigs.length) section.append(element('h3', {}, 'What was wrong with the rig'));
  for (const [camera, shared] of rigs) section.append(element('p', {}, rigText(camera, shared, report)), rigTable(shared));
}
