/** How the page names and orders verdicts; the worst first. */
export const VERDICTS = {
  unreadable: { label: 'unreadable', long: 'could not be read' },
  outside_map: { label: 'outside map', long: 'see no part of the map' },
  blurred: { label: 'blurred', long: 'are blurred' },
  kept_coarse: { label: 'kept coarse', long: 'kept the coarse pose' },
  refined: { label: 'placed', long: 'are placed' },
};
export const VERDICT_NAMES = Object.keys(VERDICTS);

export const isPlaced = (image) => image.status === 'refined';

/** Worse images have larger numbers. */
export function badness(image) {
  const rank = VERDICT_NAMES.length - VERDICT_NAMES.indexOf(image.status);
  return rank * 1e6 + Math.min(image.predicted_shift_px ?? 0, 1e5);
}

export function fixed(value, digits = 2) {
  return value === null || value === undefined ? '–' : value.toFixed(digits);
}

/** A length in the unit in which it is easy to read. */
export function length(metres) {
  const size = Math.abs(metres);
  if (size >= 1) return `${metres.toFixed(2)} m`;
  if (size >= 0.01) return `${(metres * 100).toFixed(1)} cm`;
  return `${(metres * 1000).toFixed(1)} mm`;
}

export const count = (n, one, many = `${one}s`) => `${n.toLocaleString('en')} ${n === 1 ? one : many}`;

export function median(values) {
  const sorted = values.filter((value) => value !== null && value !== undefined).sort((a, b) => a - b);
  if (sorted.length === 0) return null;
  const middle = sorted.length >> 1;
  return sorted.length % 2 ? sorted[middle] : 0.5 * (sorted[middle - 1] + sorted[middle]);
}

/** A colour for an expected shift: blue is sure, yellow is at half of the limit, red at the limit. */
export function shiftColor(shift, limit) {
  const stops = [[33, 102, 190], [48, 172, 150], [240, 196, 50], [242, 130, 45], [204, 32, 38]];
  const t = Math.min(Math.max(shift / limit, 0), 1) * (stops.length - 1);
  const i = Math.min(Math.floor(t), stops.length - 2);
  const mix = stops[i].map((from, c) => Math.round(from + (t - i) * (stops[i + 1][c] - from)));
  return `rgb(${mix.join(',')})`;
}

export const shiftLimit = (report) => Number(report.options['refine.max_predicted_shift_px'] ?? 2);
