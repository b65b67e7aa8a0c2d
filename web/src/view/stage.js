import { Color, ColorManagement, LinearSRGBColorSpace, MOUSE, PerspectiveCamera, Plane, Scene, WebGLRenderer } from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';

/** Scene, camera and controls in the frame of the map (metres, relative to the origin of the tiles). */
export function makeStage(canvas, up) {
  // The colours of points and photos are shown as they are in their files.
  ColorManagement.enabled = false;
  const renderer = new WebGLRenderer({ canvas, antialias: true, powerPreference: 'high-performance' });
  renderer.outputColorSpace = LinearSRGBColorSpace;
  const scene = new Scene();
  const camera = new PerspectiveCamera(60, 1, 0.05, 5000);
  camera.up.copy(up);
  const controls = new OrbitControls(camera, canvas);
  controls.zoomToCursor = true;
  controls.enableDamping = true;
  controls.dampingFactor = 0.12;
  controls.screenSpacePanning = true;
  controls.mouseButtons = { LEFT: MOUSE.ROTATE, MIDDLE: MOUSE.DOLLY, RIGHT: MOUSE.PAN };

  const dark = window.matchMedia('(prefers-color-scheme: dark)');
  const paint = () => { scene.background = new Color(dark.matches ? 0x15181b : 0xe9ecef); };
  dark.addEventListener('change', paint);
  paint();

  const resize = () => {
    renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    renderer.setSize(window.innerWidth, window.innerHeight, false);
    camera.aspect = window.innerWidth / window.innerHeight;
    camera.updateProjectionMatrix();
  };
  window.addEventListener('resize', resize);
  resize();

  // Frames are drawn only where something has changed: a still view costs nothing.
  let isStale = true;
  const invalidate = () => { isStale = true; };
  ['input', 'change', 'click', 'keydown', 'resize'].forEach((name) => window.addEventListener(name, invalidate));
  controls.addEventListener('change', invalidate);
  dark.addEventListener('change', invalidate);
  const run = (everyFrame) => renderer.setAnimationLoop(() => {
    if (controls.enabled) controls.update();
    if (!isStale) return;
    isStale = false;
    camera.updateMatrixWorld();
    everyFrame();
    renderer.render(scene, camera);
  });

  // Hides what is higher than this, along up; null = nothing.
  const ceiling = new Plane(up.clone().negate(), 0);
  const cutAbove = (height) => {
    ceiling.constant = height ?? 0;
    renderer.clippingPlanes = height === null ? [] : [ceiling];
    invalidate();
  };
  const isHidden = (point) => renderer.clippingPlanes.some((plane) => plane.distanceToPoint(point) < 0);
  return { canvas, renderer, scene, camera, controls, up, run, invalidate, cutAbove, isHidden };
}
