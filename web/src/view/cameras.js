import { BufferAttribute, BufferGeometry, Color, LineBasicMaterial, LineSegments, Vector3 } from 'three';
import { shiftColor } from '../report/words.js';
import { bearings, corners, matrixOf, placeOf, rotationOf } from './poses.js';

const PICK_RADIUS_PX = 14;
const OTHER_COLOR = '#8a929a';
const GLOBE_RADIUS = 0.3, GLOBE_STEPS = 16;

/** For lenses that see too much for a pyramid: a globe, and a line ahead whose tick at the end points up. */
function globe() {
  const circle = (place) => Array.from({ length: GLOBE_STEPS }, (_, i) => [i, i + 1]).flat().map((step) => {
    const angle = (2 * Math.PI * step) / GLOBE_STEPS;
    return place(GLOBE_RADIUS * Math.cos(angle), GLOBE_RADIUS * Math.sin(angle));
  });
  const end = new Vector3(0, 0, 1);
  return [
    ...circle((u, v) => new Vector3(u, 0, v)), ...circle((u, v) => new Vector3(0, u, v)), ...circle((u, v) => new Vector3(u, v, 0)),
    new Vector3(), end, end, new Vector3(0, -0.2, 0.9),
  ];
}

/** Points of a wire frame in the frame of the camera, two a line, one metre deep. */
function wireOf(grid) {
  const around = corners(grid);
  if (!around.every((corner) => corner && corner.z > 0.25)) return globe();
  const ends = around.map((corner) => corner.clone().divideScalar(corner.z));
  const lines = [];
  ends.forEach((end, i) => { lines.push(new Vector3(), end, end, ends[(i + 1) % 4]); });
  const top = ends[0].clone().add(ends[1]).multiplyScalar(0.5);
  lines.push(ends[0].clone().lerp(top, 0.6), top.clone().add(ends[0].clone().sub(ends[3]).multiplyScalar(0.18)));
  lines.push(ends[1].clone().lerp(top, 0.6), top.clone().add(ends[0].clone().sub(ends[3]).multiplyScalar(0.18)));
  return lines;
}

/** Typical distance between neighbouring photos decides how large the frusta are drawn. */
function frustumSize(images) {
  const steps = images.slice(1).map((image, i) => placeOf(image.refined).distanceTo(placeOf(images[i].refined))).sort((a, b) => a - b);
  const typical = steps.length ? steps[steps.length >> 1] : 0.5;
  return Math.min(1, Math.max(0.1, 0.45 * typical));
}

export function makeCameras(stage, view) {
  const wires = Object.fromEntries(Object.entries(view.cameras).map(([id, grid]) => [id, wireOf(grid)]));
  const state = { kind: 'refined', size: frustumSize(view.images), hovered: null, listeners: [] };
  const colorOf = (image) => new Color(image.status === 'refined' ? shiftColor(image.shift ?? 0, view.limit_px) : OTHER_COLOR);
  const frusta = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ vertexColors: true, transparent: true }));
  const trail = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color: 0xd5453a }));
  const highlight = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color: 0xffffff, depthTest: false, transparent: true }));
  highlight.renderOrder = 5;
  [frusta, trail, highlight].forEach((lines) => { lines.frustumCulled = false; stage.scene.add(lines); });

  const poseOf = (index) => view.images[index][state.kind];
  const wirePoints = (index) => {
    const matrix = matrixOf(poseOf(index));
    return wires[view.images[index].camera].map((point) => point.clone().multiplyScalar(state.size).applyMatrix4(matrix));
  };
  const setPoints = (lines, points) => lines.geometry.setAttribute('position', new BufferAttribute(new Float32Array(points.flatMap((p) => [p.x, p.y, p.z])), 3));

  function draw() {
    const points = [], colors = [];
    view.images.forEach((image, index) => {
      const color = colorOf(image);
      for (const point of wirePoints(index)) { points.push(point); colors.push(color.r, color.g, color.b); }
    });
    setPoints(frusta, points);
    frusta.geometry.setAttribute('color', new BufferAttribute(new Float32Array(colors), 3));
    setPoints(trail, view.images.flatMap((image) => [placeOf(image.coarse), placeOf(image.refined)]));
    state.listeners.forEach((listener) => listener());
    stage.invalidate();
  }

  /** The camera nearest to a place of the window, or null: by its centre and the middle of its frustum. */
  function pick(x, y) {
    if (!frusta.visible) return null;
    const point = new Vector3();
    let best = null, bestPx = PICK_RADIUS_PX;
    view.images.forEach((image, index) => {
      const pose = poseOf(index);
      const ahead = new Vector3(0, 0, state.size).applyQuaternion(rotationOf(pose));
      for (const share of [0, 0.5, 1]) {
        point.copy(placeOf(pose)).addScaledVector(ahead, share).project(stage.camera);
        if (point.z < -1 || point.z > 1) continue;
        const px = Math.hypot((point.x + 1) * 0.5 * window.innerWidth - x, (1 - point.y) * 0.5 * window.innerHeight - y);
        if (px < bestPx) { bestPx = px; best = index; }
      }
    });
    return best;
  }

  function hover(index) {
    if (index === state.hovered) return;
    state.hovered = index;
    setPoints(highlight, index === null ? [] : wirePoints(index));
    stage.canvas.style.cursor = index === null ? '' : 'pointer';
    stage.invalidate();
    stage.canvas.title = index === null ? '' : view.images[index].name;
  }

  /** Where the middle of a camera's frustum is in the window, pixels. */
  function screenPlace(index) {
    const pose = poseOf(index);
    const point = placeOf(pose).addScaledVector(new Vector3(0, 0, 0.5 * state.size).applyQuaternion(rotationOf(pose)), 1).project(stage.camera);
    return [(point.x + 1) * 0.5 * window.innerWidth, (1 - point.y) * 0.5 * window.innerHeight];
  }

  /** Looks at all cameras from above and behind. */
  function frame() {
    const places = view.images.map((image) => placeOf(image.refined));
    if (places.length === 0) return;
    const centre = places.reduce((sum, place) => sum.add(place), new Vector3()).divideScalar(places.length);
    const radius = Math.max(4, ...places.map((place) => place.distanceTo(centre)));
    const side = new Vector3(1, 0, 0).addScaledVector(stage.up, -stage.up.x);
    if (side.lengthSq() < 0.1) side.set(0, 1, 0).addScaledVector(stage.up, -stage.up.y);
    side.normalize().addScaledVector(new Vector3().crossVectors(stage.up, side), -0.7).normalize();
    stage.controls.target.copy(centre);
    stage.camera.position.copy(centre).addScaledVector(stage.up, 1.9 * radius).addScaledVector(side, 1.5 * radius);
    stage.controls.update();
    stage.invalidate();
  }

  draw();
  return {
    pick, hover, frame, screenPlace, poseOf,
    /** The height of the highest camera, metres along up. */
    get top() { return Math.max(...view.images.map((image) => placeOf(image.refined).dot(stage.up))); },
    bearingsOf: (image) => bearings(view.cameras[image.camera]),
    get kind() { return state.kind; },
    use(kind) { state.kind = kind; hover(null); draw(); },
    onChange(listener) { state.listeners.push(listener); },
    set size(size) { state.size = size; draw(); },
    get size() { return state.size; },
    set shown(on) { frusta.visible = on; },
    set trailShown(on) { trail.visible = on; },
  };
}
