import { Euler, MathUtils, Quaternion } from 'three';

const MIN_FOV_DEG = 2, MAX_FOV_DEG = 110;

/** While a photo is shown, drags turn the view on the spot and the wheel zooms. `isActive` says whether one is. */
export function makeLook(stage, isActive) {
  const state = { base: new Quaternion(), fov: 60, yaw: 0, pitch: 0, zoom: 1, from: null };
  const { camera, canvas } = stage;

  function apply() {
    camera.quaternion.copy(state.base).multiply(new Quaternion().setFromEuler(new Euler(state.pitch, state.yaw, 0, 'YXZ')));
    camera.fov = MathUtils.clamp(state.fov / state.zoom, MIN_FOV_DEG, MAX_FOV_DEG);
    camera.updateProjectionMatrix();
    stage.invalidate();
  }

  canvas.addEventListener('pointerdown', (event) => {
    if (!isActive()) return;
    state.from = [event.clientX, event.clientY];
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener('pointermove', (event) => {
    if (!state.from || !isActive()) return;
    // What is under the pointer goes with it.
    const perPixel = MathUtils.degToRad(camera.fov) / window.innerHeight;
    state.yaw += (event.clientX - state.from[0]) * perPixel;
    state.pitch = MathUtils.clamp(state.pitch + (event.clientY - state.from[1]) * perPixel, -Math.PI / 2, Math.PI / 2);
    state.from = [event.clientX, event.clientY];
    apply();
  });
  ['pointerup', 'pointercancel'].forEach((name) => canvas.addEventListener(name, () => { state.from = null; }));
  canvas.addEventListener('wheel', (event) => {
    if (!isActive()) return;
    event.preventDefault();
    const zoom = state.zoom * Math.exp(-event.deltaY / 700);
    state.zoom = MathUtils.clamp(zoom, state.fov / MAX_FOV_DEG, state.fov / MIN_FOV_DEG);
    apply();
  }, { passive: false });

  return {
    /** Straight along the camera of a photo, all of which fits into `fov` degrees. */
    reset() { Object.assign(state, { yaw: 0, pitch: 0, zoom: 1, from: null }); },
    /** The camera's rotation and field of view from which the turns and the zoom count. */
    use(rotation, fov) {
      state.base.copy(rotation);
      state.fov = fov;
      apply();
    },
  };
}
