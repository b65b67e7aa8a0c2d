import { checkbox, element } from './dom.js';
import { VERDICTS, VERDICT_NAMES, badness, count, fixed, length, shiftColor, shiftLimit } from './words.js';

const ROWS_PER_PAGE = 50;

function shiftCell(image, limit) {
  const shift = image.predicted_shift_px;
  if (shift === null || image.matches === 0) return '–';
  return element('span', { class: 'shift', style: `--c:${shiftColor(shift, limit)}` }, fixed(shift));
}

const columns = (limit) => [
  { id: 'picture', title: '', cell: (image) => (image.pictures
    ? element('img', { src: image.pictures[0], loading: 'lazy', decoding: 'async', alt: '' }) : '') },
  { id: 'name', title: 'Photo', value: (image) => image.name, cell: (image) => element('a', { href: '#photos' }, image.name) },
  { id: 'status', title: 'Verdict', value: badness,
    cell: (image) => element('span', { class: `badge ${image.status}` }, VERDICTS[image.status].label) },
  { id: 'shift', title: 'Expected shift px', number: true, value: (image) => image.predicted_shift_px,
    cell: (image) => shiftCell(image, limit) },
  { id: 'before', title: 'Held-out residual before px', number: true, value: (image) => image.held_out_before.median_px },
  { id: 'after', title: 'after px', number: true, value: (image) => image.held_out_after.median_px },
  { id: 'inliers', title: 'Edges that fit, after', number: true, value: (image) => image.held_out_after.inlier_share,
    cell: (image) => (image.held_out_after.inlier_share === null ? '–' : `${fixed(100 * image.held_out_after.inlier_share, 0)} %`) },
  { id: 'edges', title: 'Map edges', number: true, value: (image) => image.map_edges, cell: (image) => String(image.map_edges) },
  { id: 'moved', title: 'Moved', number: true, value: (image) => image.moved_m ?? 0,
    cell: (image) => (image.moved_m ? `${length(image.moved_m)}, ${fixed(image.moved_deg)}°` : '–') },
  { id: 'weak', title: 'Weak directions', value: (image) => image.weak_directions.length,
    cell: (image) => image.weak_directions.join(', ') },
  { id: 'reason', title: 'Reason', value: (image) => image.reason, cell: (image) => image.reason },
];

function compare(a, b) {
  if (a === b) return 0;
  if (a === null || a === undefined) return 1;
  if (b === null || b === undefined) return -1;
  return typeof a === 'string' ? a.localeCompare(b, 'en', { numeric: true }) : a - b;
}

/** A table of all photos: sorted by a click on a head, filtered by verdict and name, one page at a time. */
export function showTable(report, open) {
  const all = columns(shiftLimit(report));
  const state = { column: all[2], ascending: false, page: 0, text: '', onlyWeak: false, verdicts: new Set(VERDICT_NAMES) };
  const table = document.getElementById('table');
  const pager = document.getElementById('pager');

  const selected = () => {
    const text = state.text.toLowerCase();
    const kept = report.images.filter((image) => state.verdicts.has(image.status)
      && (!state.onlyWeak || image.weak_directions.length > 0)
      && (image.name.toLowerCase().includes(text) || image.reason.toLowerCase().includes(text)));
    const sign = state.ascending ? 1 : -1;
    // Photos without the figure stay at the end either way.
    const missing = (image) => state.column.value(image) === null;
    return kept.sort((a, b) => (missing(a) - missing(b)) || sign * compare(state.column.value(a), state.column.value(b)) || a.index - b.index);
  };

  const sortBy = (column) => {
    state.ascending = state.column === column ? !state.ascending : !column.number && column.id !== 'status' && column.id !== 'weak';
    state.column = column;
    state.page = 0;
    draw();
  };

  const head = () => element('tr', {}, ...all.map((column) => element('th', {
    class: column.number ? 'n' : null,
    'data-column': column.id,
    'aria-sort': column === state.column ? (state.ascending ? 'ascending' : 'descending') : null,
  }, column.value ? element('button', { click: () => sortBy(column) }, column.title) : '')));

  const row = (image, list) => element('tr', { 'data-index': image.index, click: (event) => { event.preventDefault(); open(image, list); } },
    ...all.map((column) => element('td', { class: `${column.number ? 'n ' : ''}${column.id}` },
      column.cell ? column.cell(image) : fixed(column.value(image)))));

  function draw() {
    const list = selected();
    const pages = Math.max(1, Math.ceil(list.length / ROWS_PER_PAGE));
    state.page = Math.min(state.page, pages - 1);
    const first = state.page * ROWS_PER_PAGE;
    table.tHead.replaceChildren(head());
    table.tBodies[0].replaceChildren(...list.slice(first, first + ROWS_PER_PAGE).map((image) => row(image, list)));
    const go = (page) => () => { state.page = page; draw(); };
    pager.replaceChildren(
      element('button', { click: go(state.page - 1), disabled: state.page === 0, 'aria-label': 'previous page' }, '‹'),
      element('span', {}, `${count(list.length, 'photo')} · page ${state.page + 1} of ${pages}`),
      element('button', { click: go(state.page + 1), disabled: state.page === pages - 1, 'aria-label': 'next page' }, '›'));
  }

  const refresh = (change) => (value) => { change(value); state.page = 0; draw(); };
  const present = [...VERDICT_NAMES].reverse().filter((status) => report.images.some((image) => image.status === status));
  const search = element('input', { type: 'search', placeholder: 'name or reason', 'aria-label': 'filter by name or reason',
    input: () => refresh((text) => { state.text = text; })(search.value) });
  document.getElementById('table-controls').append(search,
    ...present.map((status) => checkbox(
      `${VERDICTS[status].label} (${report.images.filter((image) => image.status === status).length})`, true,
      refresh((on) => (on ? state.verdicts.add(status) : state.verdicts.delete(status))))),
    checkbox('only with weak directions', false, refresh((on) => { state.onlyWeak = on; })));
  draw();
}
