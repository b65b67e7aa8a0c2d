import './report.css';
import { showCharts } from './charts.js';
import { showDetail } from './detail.js';
import { showMap } from './map.js';
import { showRun } from './run.js';
import { showSummary } from './summary.js';
import { showTable } from './table.js';

const report = window.cpplusReport;
report.images.forEach((image, index) => {
  image.index = index;
  // Without samples there is nothing that the figures tell.
  for (const residual of [image.before, image.after, image.held_out_before, image.held_out_after]) {
    if (residual.samples === 0) residual.median_px = residual.rms_px = residual.inlier_share = residual.log_ratio = null;
  }
  if (image.moved_m < 1e-6 && image.moved_deg < 1e-6) image.moved_m = image.moved_deg = 0;
});

const open = (image, list) => showDetail(document.getElementById('detail'), image, list ?? report.images);
showSummary(document.getElementById('summary'), report);
showMap(report, open);
showCharts(report);
showTable(report, open);
showRun(document.getElementById('run'), report);
