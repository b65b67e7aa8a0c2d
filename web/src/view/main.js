import './view.css';
import { Vector3 } from 'three';
import { makeCameras } from './cameras.js';
import { makeCloud } from './cloud.js';
import { makeMeasure } from './measure.js';
import { makePanel } from './panel.js';
import { makePhoto } from './photo.js';
import { makeStage } from './stage.js';

const view = window.cpplusView;
const stage = makeStage(document.getElementById('scene'), new Vector3(...view.up));
const cloud = makeCloud(stage);
const cameras = makeCameras(stage, view);
const photo = makePhoto(stage, view, cameras);
const measure = makeMeasure(stage, cloud);
const panel = makePanel({ view, stage, cloud, cameras, photo, measure });

// A click picks a point while measuring, else a camera. Dragging is no click.
let pressed = null;
stage.canvas.addEventListener('pointerdown', (event) => { pressed = [event.clientX, event.clientY]; });
stage.canvas.addEventListener('pointerup', (event) => {
  if (!pressed || Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 4 || event.button !== 0) return;
  if (measure.active) return measure.pick(event.clientX, event.clientY);
  if (photo.shown) return;
  const index = cameras.pick(event.clientX, event.clientY);
  if (index !== null) photo.show(index);
});
stage.canvas.addEventListener('pointermove', (event) => {
  if (event.buttons || photo.shown || measure.active) return;
  cameras.hover(cameras.pick(event.clientX, event.clientY));
});
window.addEventListener('keydown', (event) => {
  if (event.target instanceof HTMLInputElement && event.target.type !== 'range') return;
  if (event.key === 'Escape') { if (measure.active) measure.stop(); else photo.hide(); }
  if (event.key === 'ArrowRight' && photo.shown) photo.step(1);
  if (event.key === 'ArrowLeft' && photo.shown) photo.step(-1);
  if (event.key === 'r') cameras.use(cameras.kind === 'refined' ? 'coarse' : 'refined');
});

cameras.frame();
stage.run(() => { cloud.update(); panel.update(); measure.update(); });
// For tests: what there is to be clicked.
window.cpplusViewer = { stage, cloud, cameras, photo, measure };
