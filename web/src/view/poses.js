import { Matrix4, Quaternion, Vector3 } from 'three';

/** [qx, qy, qz, qw, x, y, z] of map_from_camera as three's rotation and place. */
export const rotationOf = (pose) => new Quaternion(pose[0], pose[1], pose[2], pose[3]).normalize();
export const placeOf = (pose) => new Vector3(pose[4], pose[5], pose[6]);
export const matrixOf = (pose) => new Matrix4().compose(placeOf(pose), rotationOf(pose), new Vector3(1, 1, 1));

// A camera of the map looks along +z with y down, one of three along -z with y up.
const HALF_TURN_ABOUT_X = new Quaternion(1, 0, 0, 0);
export const viewRotationOf = (pose) => rotationOf(pose).multiply(HALF_TURN_ABOUT_X);

/** The bearings of a camera's grid, as vectors or null. */
export function bearings(grid) {
  const result = [];
  for (let i = 0; i < grid.bearings.length; i += 3) {
    result.push(grid.bearings[i] === null ? null : new Vector3(grid.bearings[i], grid.bearings[i + 1], grid.bearings[i + 2]));
  }
  return result;
}

/** The corners of the photo that have a bearing, in order around it. */
export function corners(grid) {
  const all = bearings(grid);
  const last = grid.columns - 1;
  const bottom = (grid.rows - 1) * grid.columns;
  return [all[0], all[last], all[bottom + last], all[bottom]];
}
