import { TilesRenderer } from '3d-tiles-renderer/three';
import { Box3, Raycaster, Vector2, Vector3 } from 'three';
import { makePace } from './pace.js';

/** The tiles of the cloud: levels of detail come and go with the view. */
export function makeCloud(stage) {
  const tiles = new TilesRenderer(new URL('tileset.json', document.baseURI).href);
  const state = { pointSize: 2, detail: 2.5 };
  const pace = makePace(stage);
  const loaded = new Set();
  tiles.lruCache.minSize = 400;
  tiles.lruCache.maxSize = 1200;
  tiles.setCamera(stage.camera);
  stage.scene.add(tiles.group);

  // Means of voxels are drawn as large as their voxels, so that no holes show; the points themselves in pixels.
  const style = (points) => {
    const { spacing } = points.userData;
    points.material.sizeAttenuation = spacing > 0;
    points.material.size = spacing > 0 ? 0.6 * state.pointSize * spacing : state.pointSize * stage.renderer.getPixelRatio();
    points.material.needsUpdate = true;
  };
  tiles.addEventListener('load-model', ({ scene, tile }) => {
    scene.traverse((node) => {
      if (!node.isPoints) return;
      node.userData.spacing = tile.geometricError;
      style(node);
      loaded.add(node);
    });
  });
  tiles.addEventListener('dispose-model', ({ scene }) => scene.traverse((node) => loaded.delete(node)));

  ['needs-update', 'needs-render', 'load-model', 'tile-visibility-change'].forEach((name) => tiles.addEventListener(name, stage.invalidate));

  const raycaster = new Raycaster();
  /** The point that is seen at a place of the window, or null: of those near the ray the nearest to the camera. */
  const pointAt = (x, y) => {
    raycaster.setFromCamera(new Vector2((x / window.innerWidth) * 2 - 1, 1 - (y / window.innerHeight) * 2), stage.camera);
    const pixel = (2 * Math.tan((stage.camera.fov * Math.PI) / 360)) / window.innerHeight;
    const hits = [];
    for (const threshold of [0.01, 0.03, 0.08, 0.2]) {
      raycaster.params.Points.threshold = threshold;
      hits.length = 0;
      raycaster.intersectObject(tiles.group, true, hits);
      const near = hits.filter((hit) => hit.distanceToRay < 4 * pixel * hit.distance + 0.002 && !stage.isHidden(hit.point));
      if (near.length) return near.reduce((a, b) => (a.distance < b.distance ? a : b)).point;
    }
    return null;
  };

  return {
    pointAt,
    /** The height of the highest place of the cloud, metres along up; null until it is known. */
    get top() {
      const box = new Box3();
      if (!tiles.getBoundingBox(box)) return null;
      const corner = new Vector3(...['x', 'y', 'z'].map((axis) => (stage.up[axis] > 0 ? box.max[axis] : box.min[axis])));
      return corner.dot(stage.up);
    },
    /** Points in the tiles that are drawn now. */
    get numDrawn() {
      let count = 0;
      tiles.forEachLoadedModel((scene, tile) => {
        if (tiles.visibleTiles.has(tile)) scene.traverse((node) => { if (node.isPoints) count += node.geometry.attributes.position.count; });
      });
      return count;
    },
    /** Whether more will be seen of this view. */
    get isLoading() { return pace.isCoarser || tiles.stats.downloading + tiles.stats.parsing > 0 || tiles.root === null; },
    set pointSize(size) { state.pointSize = size; loaded.forEach(style); },
    set detail(px) { state.detail = px; stage.invalidate(); },
    set shown(on) { tiles.group.visible = on; },
    update() {
      tiles.errorTarget = state.detail * pace.coarser();
      tiles.setResolutionFromRenderer(stage.camera, stage.renderer);
      tiles.update();
    },
  };
}
