import { Color, MOUSE, PerspectiveCamera, Scene, WebGLRenderer } from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';

/** Scene, camera and controls in the frame of the map (metres, relative to the origin of the tiles). */
export function makeStage(canvas, up) {
  const renderer = new WebGLRenderer({ canvas, antialias: true, powerPreference: 'high-performance' });
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

  const run = (everyFrame) => renderer.setAnimationLoop(() => {
    if (controls.enabled) controls.update();
    camera.updateMatrixWorld();
    everyFrame();
    renderer.render(scene, camera);
  });
  return { canvas, renderer, scene, camera, controls, up, run };
}
