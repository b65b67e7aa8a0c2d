import { element } from './dom.js';

const GIVEN = ['map', 'images', 'poses', 'out', 'stamps', 'trajectory'];

const table = (rows) => element('table', { class: 'plain' }, element('tbody', {}, ...rows.map(([name, value]) =>
  element('tr', {}, element('td', {}, name), element('td', {}, value)))));

/** Version, inputs and every option. */
export function showRun(section, report) {
  const map = report.map;
  const options = Object.entries(report.options);
  section.append(element('h2', {}, 'How this was made'), table([
    ['program', `cpplus ${report.version}`],
    ...options.filter(([name, value]) => GIVEN.includes(name) && value !== '').map(([name, value]) => [name, String(value)]),
    ['points of the map', map.points.toLocaleString('en')],
    ['noise of its points', map.noise_m === null ? '–' : `${(1000 * map.noise_m).toFixed(1)} mm`],
    ['planes, edges', `${map.planes.toLocaleString('en')}, ${map.edges.toLocaleString('en')}`],
  ]), element('details', {}, element('summary', {}, `all ${options.length} options`),
    table(options.map(([name, value]) => [name, value === '' ? '–' : String(value)]))));
}
