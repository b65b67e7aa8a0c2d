import { BufferAttribute, BufferGeometry, DoubleSide, Mesh, MeshBasicMaterial, NoColorSpace, TextureLoader } from 'three';
import { element } from '../report/dom.js';
import { VERDICTS, fixed } from '../report/words.js';
import { makeLook } from './look.js';
import { matrixOf, placeOf, viewRotationOf } from './poses.js';

const MAX_FOV_DEG = 95;

/** The photo's rays as a surface at distance 1, which bends as the lens does; cells without rays are left out. */
function photoSurface(grid, rays) {
  const positions = [], uvs = [], indices = [];
  rays.forEach((ray, i) => {
    positions.push(...(ray ? [ray.x, ray.y, ray.z] : [0, 0, 0]));
    uvs.push((i % grid.columns) / (grid.columns - 1), 1 - Math.floor(i / grid.columns) / (grid.rows - 1));
  });
  for (let row = 0; row + 1 < grid.rows; row += 1) {
    for (let column = 0; column + 1 < grid.columns; column += 1) {
      const a = row * grid.columns + column;
      const cell = [a, a + 1, a + grid.columns, a + grid.columns + 1];
      if (cell.every((i) => rays[i])) indices.push(cell[0], cell[2], cell[1], cell[1], cell[2], cell[3]);
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(positions), 3));
  geometry.setAttribute('uv', new BufferAttribute(new Float32Array(uvs), 2));
  geometry.setIndex(indices);
  return geometry;
}

/** Field of view, degrees, with which the whole photo fits into a window of that shape. */
function fittingFov(rays, aspect) {
  let tall = 0.05;
  for (const ray of rays) {
    if (!ray || ray.z < 0.2) continue;
    tall = Math.max(tall, Math.abs(ray.y / ray.z), Math.abs(ray.x / ray.z) / aspect);
  }
  return Math.min(MAX_FOV_DEG, (2 * Math.atan(1.04 * tall) * 180) / Math.PI);
}

/** Goes to the pose of a photo and lays the photo over the cloud. */
export function makePhoto(stage, view, cameras) {
  const bar = document.getElementById('photo-bar');
  const surface = new Mesh(new BufferGeometry(), new MeshBasicMaterial({ transparent: true, depthTest: false, depthWrite: false, side: DoubleSide }));
  surface.renderOrder = 3;
  surface.visible = false;
  surface.frustumCulled = false;
  stage.scene.add(surface);
  const loader = new TextureLoader();
  const state = { index: null, opacity: 0.6, home: null, ready: false };
  const look = makeLook(stage, () => state.index !== null);

  function goToPose() {
    stage.cutAbove(null);
    const image = view.images[state.index];
    const pose = cameras.poseOf(state.index);
    const rays = cameras.bearingsOf(image);
    stage.camera.position.copy(placeOf(pose));
    look.use(viewRotationOf(pose), fittingFov(rays, stage.camera.aspect));
    surface.matrixAutoUpdate = false;
    surface.matrix.copy(matrixOf(pose));
    surface.matrixWorldNeedsUpdate = true;
    stage.invalidate();
  }

  function loadPhoto(image) {
    const index = state.index;
    state.ready = false;
    surface.visible = false;
    surface.geometry.dispose();
    surface.geometry = photoSurface(view.cameras[image.camera], cameras.bearingsOf(image));
    loader.load(image.photo, (texture) => {
      if (state.index !== index) return texture.dispose();
      texture.colorSpace = NoColorSpace;
      surface.material.map?.dispose();
      surface.material.map = texture;
      surface.material.needsUpdate = true;
      surface.visible = true;
      state.ready = true;
      stage.invalidate();
    }, undefined, () => { document.getElementById('status').textContent = `${image.name}: the photo cannot be loaded`; });
  }

  function drawBar() {
    const image = view.images[state.index];
    const slider = element('input', { type: 'range', min: 0, max: 1, step: 0.01, 'aria-label': 'opacity of the photo',
      input: () => { state.opacity = Number(slider.value); surface.material.opacity = state.opacity; } });
    slider.value = state.opacity;
    surface.material.opacity = state.opacity;
    bar.replaceChildren(
      element('button', { click: () => photo.step(-1), 'aria-label': 'previous photo' }, '‹'),
      element('button', { click: () => photo.step(1), 'aria-label': 'next photo' }, '›'),
      element('b', { title: image.name }, image.name),
      element('span', { class: `badge ${image.status}` }, VERDICTS[image.status].label + (image.status === 'refined' && image.shift !== null ? ` · ${fixed(image.shift)} px` : '')),
      element('span', { class: 'muted' }, `${cameras.kind} pose`),
      element('label', {}, 'cloud', slider, 'photo'),
      element('button', { click: () => photo.hide() }, 'back'));
    bar.hidden = false;
  }

  const photo = {
    get shown() { return state.index !== null; },
    get ready() { return state.ready; },
    get index() { return state.index; },
    show(index) {
      if (state.index === null) {
        state.home = { position: stage.camera.position.clone(), quaternion: stage.camera.quaternion.clone(), fov: stage.camera.fov };
      }
      const isOther = state.index !== index;
      state.index = index;
      if (isOther) look.reset();
      stage.controls.enabled = false;
      cameras.shown = false;
      cameras.trailShown = false;
      cameras.hover(null);
      goToPose();
      if (isOther) loadPhoto(view.images[index]);
      drawBar();
    },
    step(by) { photo.show((state.index + by + view.images.length) % view.images.length); },
    hide() {
      if (state.index === null) return;
      state.index = null;
      surface.visible = false;
      bar.hidden = true;
      stage.camera.position.copy(state.home.position);
      stage.camera.quaternion.copy(state.home.quaternion);
      stage.camera.fov = state.home.fov;
      stage.camera.updateProjectionMatrix();
      stage.controls.enabled = true;
      photo.onHide?.();
      stage.invalidate();
    },
  };
  cameras.onChange(() => { if (photo.shown) photo.show(state.index); });
  window.addEventListener('resize', () => { if (photo.shown) goToPose(); });
  return photo;
}
