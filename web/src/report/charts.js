import { makeChart } from './echarts.js';
import { isPlaced, shiftColor, shiftLimit } from './words.js';

/** Counts of values in equal bins up to `max`; the last bin takes what is beyond. */
export function histogram(values, max, bins) {
  const counts = new Array(bins).fill(0);
  for (const value of values) {
    if (value === null || value === undefined) continue;
    counts[Math.min(bins - 1, Math.max(0, Math.floor((value / max) * bins)))] += 1;
  }
  return counts;
}

const labels = (max, bins, digits) => Array.from({ length: bins }, (_, i) => ((i * max) / bins).toFixed(digits));

function bars(names, series, colors) {
  return {
    animation: false,
    grid: { left: 8, right: 12, top: series.length > 1 ? 30 : 12, bottom: 4, containLabel: true },
    legend: series.length > 1 ? { top: 0, right: 0, textStyle: { color: colors.muted }, itemWidth: 12, itemHeight: 8 } : undefined,
    tooltip: { trigger: 'axis', axisPointer: { type: 'shadow' } },
    xAxis: { type: 'category', data: names, axisLabel: { color: colors.muted, hideOverlap: true }, axisTick: { show: false }, axisLine: { lineStyle: { color: colors.line } } },
    yAxis: { type: 'value', minInterval: 1, axisLabel: { color: colors.muted }, splitLine: { lineStyle: { color: colors.line } } },
    series: series.map((one) => ({ type: 'bar', barCategoryGap: '12%', barGap: '0%', ...one })),
  };
}

function beforeAfter(id, images, max, bins, digits, pick, unit) {
  const names = labels(max, bins, digits).map((label) => label + unit);
  makeChart(id, (colors) => bars(names, [
    { name: 'before', data: histogram(images.map((image) => pick(image.held_out_before)), max, bins), itemStyle: { color: colors.before } },
    { name: 'after', data: histogram(images.map((image) => pick(image.held_out_after)), max, bins), itemStyle: { color: colors.after } },
  ], colors));
}

export function showCharts(report) {
  const placed = report.images.filter(isPlaced);
  const judged = report.images.filter((image) => image.held_out_after.samples > 0);
  const limit = shiftLimit(report);
  const bins = 20;
  const counts = histogram(placed.map((image) => image.predicted_shift_px).filter((shift) => shift !== null), limit, bins);
  makeChart('shift-chart', (colors) => bars(labels(limit, bins, 1), [{
    name: 'photos', data: counts.map((value, i) => ({ value, itemStyle: { color: shiftColor(((i + 0.5) * limit) / bins, limit) } })),
  }], colors));
  beforeAfter('residual-chart', judged, 5, 20, 2, (residual) => residual.median_px, '');
  beforeAfter('inlier-chart', judged, 1, 20, 2, (residual) => residual.inlier_share, '');
}
