import { BarChart, CustomChart, LinesChart, ScatterChart } from 'echarts/charts';
import { DataZoomInsideComponent, GridComponent, LegendComponent, TooltipComponent } from 'echarts/components';
import { init, use } from 'echarts/core';
import { CanvasRenderer } from 'echarts/renderers';

use([BarChart, CustomChart, LinesChart, ScatterChart, DataZoomInsideComponent, GridComponent, LegendComponent, TooltipComponent, CanvasRenderer]);

const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/** A chart that follows the size of its element and the light or dark of the page; `options(colors)` describes it. */
export function makeChart(id, options) {
  const node = document.getElementById(id);
  const chart = init(node);
  const draw = () => chart.setOption(options({
    text: css('--text'), muted: css('--muted'), line: css('--line'), before: css('--before'), after: css('--after'),
    accent: css('--accent'), surface: css('--surface'),
  }), { replaceMerge: ['series'] });
  draw();
  window.matchMedia('(prefers-color-scheme: dark)').addEventListener('change', draw);
  new ResizeObserver(() => { chart.resize(); draw(); }).observe(node);
  return { chart, draw };
}
