import { checkbox, element } from './dom.js';
import { makeChart } from './echarts.js';
import { VERDICTS, fixed, isPlaced, length, shiftColor, shiftLimit } from './words.js';

/** Ranges of both axes around the photos, in the same scale for x and y. */
function ranges(images, width, height) {
  const xs = images.flatMap((image) => [image.at_before[0], image.at_after[0]]);
  const ys = images.flatMap((image) => [image.at_before[1], image.at_after[1]]);
  const low = [Math.min(...xs), Math.min(...ys)];
  const high = [Math.max(...xs), Math.max(...ys)];
  const centre = [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2];
  const margin = Math.max(2.5, 0.12 * Math.max(high[0] - low[0], high[1] - low[1]));
  const scale = Math.max((high[0] - low[0] + 2 * margin) / width, (high[1] - low[1] + 2 * margin) / height);
  return centre.map((c, i) => { const half = 0.5 * scale * [width, height][i]; return [c - half, c + half]; });
}

function floorPlan(report, show) {
  return {
    type: 'custom', silent: true, z: 0, data: report.floor_plan && show ? [[...report.floor_plan.min, ...report.floor_plan.max]] : [],
    clip: true,
    renderItem: (params, api) => {
      const topLeft = api.coord([api.value(0), api.value(3)]);
      const bottomRight = api.coord([api.value(2), api.value(1)]);
      return { type: 'image', style: { image: 'floor_plan.png', x: topLeft[0], y: topLeft[1], width: bottomRight[0] - topLeft[0], height: bottomRight[1] - topLeft[1] } };
    },
  };
}

const moves = (images, colors) => ({
  type: 'custom', silent: true, z: 1, clip: true, data: images.map((image) => [...image.at_before, ...image.at_after]),
  renderItem: (params, api) => {
    const from = api.coord([api.value(0), api.value(1)]);
    const to = api.coord([api.value(2), api.value(3)]);
    return { type: 'group', children: [
      { type: 'line', shape: { x1: from[0], y1: from[1], x2: to[0], y2: to[1] }, style: { stroke: colors.before, lineWidth: 1.2 } },
      { type: 'circle', shape: { cx: from[0], cy: from[1], r: 2 }, style: { fill: colors.before } }] };
  },
});

/** The ellipse within which a place is known; its long axis is the weak direction of the place. */
const ellipses = (images, colors, factor) => ({
  type: 'custom', silent: true, z: 1, clip: true,
  data: images.filter((image) => image.ellipse && factor > 0).map((image) => [...image.at_after, ...image.ellipse, image.weak_directions.length]),
  renderItem: (params, api) => {
    const [cx, cy] = api.coord([api.value(0), api.value(1)]);
    const px = api.size([1, 1])[0] * factor;
    const weak = api.value(5) > 0;
    const shape = { cx: 0, cy: 0, rx: api.value(2) * px, ry: api.value(3) * px };
    return { type: 'ellipse', shape, x: cx, y: cy, rotation: api.value(4), style: { fill: 'transparent', stroke: weak ? colors.before : colors.muted, lineWidth: weak ? 1.4 : 0.8 } };
  },
});

function photos(images, limit, colors) {
  return {
    type: 'scatter', z: 3, symbol: 'path://M0 -10 L7 8 L0 4 L-7 8 Z', symbolKeepAspect: true, clip: true,
    symbolSize: images.length > 1500 ? 10 : 20,
    data: images.map((image) => ({
      value: image.at_after, image,
      symbolRotate: (Math.atan2(image.looks[1], image.looks[0]) * 180) / Math.PI - 90,
      itemStyle: isPlaced(image)
        ? { color: shiftColor(image.predicted_shift_px, limit), borderColor: colors.text, borderWidth: 0.4 }
        : { color: colors.surface, borderColor: colors.text, borderWidth: 1.2 },
    })),
  };
}

function tooltip({ data }) {
  const image = data.image;
  const box = element('div', { class: 'tip' }, image.pictures ? element('img', { src: image.pictures[0], alt: '' }) : '',
    element('b', {}, image.name), element('div', {}, VERDICTS[image.status].label
      + (isPlaced(image) && image.predicted_shift_px !== null ? `, expected shift ${fixed(image.predicted_shift_px)} px` : '')),
    element('div', {}, image.moved_m ? `moved ${length(image.moved_m)}, ${fixed(image.moved_deg)}°` : image.reason));
  return box;
}

function legend(limit) {
  const steps = Array.from({ length: 9 }, (_, i) => shiftColor((i * limit) / 8, limit));
  return element('span', { class: 'ramp' }, '0', element('i', { style: `background:linear-gradient(90deg,${steps.join(',')})` }),
    `${limit} px`, element('i', { class: 'hollow' }), 'not placed');
}

export function showMap(report, open) {
  const images = report.images.filter((image) => image.at_after);
  const node = document.getElementById('map-chart');
  if (images.length === 0) { node.replaceWith('The coarse model names none of these photos.'); return; }
  const limit = shiftLimit(report);
  const state = { plan: true, moves: true, ellipses: 0 };
  const axis = (range, colors) => ({ type: 'value', min: range[0], max: range[1], axisLabel: { color: colors.muted, formatter: (value) => `${Math.round(value * 10) / 10}`, hideOverlap: true, showMinLabel: false, showMaxLabel: false }, axisLine: { show: false }, axisTick: { show: false }, splitLine: { lineStyle: { color: colors.line, opacity: 0.6 } } });
  const { chart, draw } = makeChart('map-chart', (colors) => {
    const [x, y] = ranges(images, node.clientWidth - 52, node.clientHeight - 40);
    return {
      animation: false,
      grid: { left: 42, right: 10, top: 10, bottom: 30 },
      xAxis: axis(x, colors), yAxis: axis(y, colors),
      tooltip: { trigger: 'item', formatter: tooltip, backgroundColor: colors.surface, borderColor: colors.line, textStyle: { color: colors.text } },
      dataZoom: [{ type: 'inside', xAxisIndex: 0, filterMode: 'none' }, { type: 'inside', yAxisIndex: 0, filterMode: 'none' }],
      series: [floorPlan(report, state.plan), moves(state.moves ? images : [], colors), ellipses(images, colors, state.ellipses), photos(images, limit, colors)],
    };
  });
  chart.on('click', ({ data }) => { if (data?.image) open(data.image); });
  const factor = element('select', { 'aria-label': 'ellipses', change: () => { state.ellipses = Number(factor.value); draw(); } },
    ...[[0, 'no ellipses'], [1, 'ellipses, true size'], [10, 'ellipses × 10'], [100, 'ellipses × 100']].map(([value, text]) => element('option', { value }, text)));
  document.getElementById('map-controls').append(legend(limit),
    report.floor_plan ? checkbox('map', true, (on) => { state.plan = on; draw(); }) : '',
    checkbox('coarse places', true, (on) => { state.moves = on; draw(); }), factor);
}
