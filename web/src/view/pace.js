import { Matrix4 } from 'three';

const SLOW_MS = 60;
const FAST_MS = 30;
const REST_MS = 1200; // longer than a frame may take
const MAX_COARSER = 32;

/** The controls find the same pose anew each frame, up to rounding. */
const hasMoved = (before, now) => before.elements.some((value, i) => Math.abs(value - now.elements[i]) > 1e-5 * Math.max(1, Math.abs(value)));

/** How much coarser than asked for a view is drawn while it moves, so that frames follow each other; at rest it is not. */
export function makePace(stage) {
  const lastPose = new Matrix4();
  let lastFrame = 0;
  let isMoving = false;
  let whileMoving = 1; // kept from one movement to the next
  let timer = null;
  const rest = () => {
    isMoving = false;
    stage.invalidate();
  };
  return {
    get isCoarser() { return isMoving && whileMoving > 1; },
    /** To be called once a frame. A factor, 1 or larger, for the error that a tile may have. */
    coarser() {
      const now = performance.now();
      const elapsed = now - lastFrame;
      lastFrame = now;
      if (!hasMoved(lastPose, stage.camera.matrixWorld)) return isMoving ? whileMoving : 1;
      lastPose.copy(stage.camera.matrixWorld);
      if (isMoving && elapsed > SLOW_MS) whileMoving = Math.min(MAX_COARSER, 1.5 * whileMoving);
      if (isMoving && elapsed < FAST_MS) whileMoving = Math.max(1, whileMoving / 1.1);
      clearTimeout(timer);
      timer = setTimeout(rest, REST_MS);
      isMoving = true;
      return whileMoving;
    },
  };
}
