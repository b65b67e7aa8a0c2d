import { BufferAttribute, BufferGeometry, Line, LineBasicMaterial, Points, PointsMaterial } from 'three';

/** Distance between two clicked points of the cloud. */
export function makeMeasure(stage, cloud) {
  const label = document.getElementById('measure-label');
  const geometry = new BufferGeometry();
  const line = new Line(geometry, new LineBasicMaterial({ color: 0xff8c00, depthTest: false, transparent: true }));
  const dots = new Points(geometry, new PointsMaterial({ color: 0xff8c00, size: 9, sizeAttenuation: false, depthTest: false, transparent: true }));
  [line, dots].forEach((object) => { object.renderOrder = 9; object.frustumCulled = false; stage.scene.add(object); });
  const state = { active: false, points: [] };

  const draw = () => geometry.setAttribute('position', new BufferAttribute(new Float32Array(state.points.flatMap((p) => [p.x, p.y, p.z])), 3));
  draw();
  const measure = {
    get active() { return state.active; },
    get distance() { return state.points.length === 2 ? state.points[0].distanceTo(state.points[1]) : null; },
    start() { state.active = true; state.points = []; stage.canvas.style.cursor = 'crosshair'; draw(); measure.onChange?.(); },
    stop() { state.active = false; state.points = []; stage.canvas.style.cursor = ''; draw(); measure.onChange?.(); },
    pick(x, y) {
      const point = cloud.pointAt(x, y);
      if (!point) return;
      if (state.points.length === 2) state.points = [];
      state.points.push(point.clone());
      draw();
      measure.onChange?.();
      stage.invalidate();
    },
    /** Keeps the label at the middle of the line. */
    update() {
      label.hidden = state.points.length < 2;
      if (label.hidden) return;
      const middle = state.points[0].clone().lerp(state.points[1], 0.5).project(stage.camera);
      label.style.left = `${(middle.x + 1) * 50}%`;
      label.style.top = `${(1 - middle.y) * 50}%`;
      label.style.visibility = Math.abs(middle.z) <= 1 ? 'visible' : 'hidden';
      label.textContent = `${measure.distance.toFixed(3)} m`;
    },
  };
  return measure;
}
