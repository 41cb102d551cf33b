// Loads every tile of a tileset in a viewer of others, in headless Chromium.
//
//   npm install cesium three 3d-tiles-renderer meshoptimizer
//                                          (anywhere; NODE_PATH or the current folder leads to it)
//   node bench/quality/load_tileset.js [--in cesium|3d-tiles-renderer] [--picture FILE.png] FOLDER
//
// The viewer refines wherever a tile has an error, with all of the tileset in view. Prints one line
// of JSON: tiles of tileset.json, tiles that were loaded, errors, and the triangles of the finest picture.
// Exit status 0: all tiles were loaded, without an error; 1: not so; 77: node modules or Chromium
// are not installed.
'use strict';
const fs = require('fs');
const path = require('path');
const { chromium, told } = require('./browser.js');

const kViewers = {
  cesium: { modules: ['cesium'], page: cesiumPage },
  '3d-tiles-renderer': { modules: ['three', '3d-tiles-renderer', 'meshoptimizer'], page: rendererPage },
};

/// The folder of node modules that has all of them, or null.
function moduleFolder(names) {
  const folders = [...(process.env.NODE_PATH || '').split(':').filter(Boolean),
                   path.join(process.cwd(), 'node_modules'), path.join(__dirname, 'node_modules')];
  return folders.find((folder) => names.every((name) => fs.existsSync(path.join(folder, name)))) || null;
}

function tilesOf(tile) {
  return 1 + (tile.children || []).reduce((sum, child) => sum + tilesOf(child), 0);
}

/// What both pages begin with: errors of all kinds end up in one list, which is sent with the picture.
const kCommon = `
const errors = [];
const tell = (what) => { errors.push(String((what && (what.message || what.reason || what.error)) || what)); };
window.addEventListener('error', tell);
window.addEventListener('unhandledrejection', tell);
const complain = console.error;
console.error = (...all) => { tell(all.join(' ')); complain(...all); };
setTimeout(() => done({ loaded: 0, errors: [...errors, 'not all tiles came in time'] }), 500e3);
const done = (facts, canvas) => fetch('/done', { method: 'POST',
  body: JSON.stringify({ errors, ...facts, picture: canvas ? canvas.toDataURL('image/png') : null }) });
`;

function cesiumPage() {
  return `<!DOCTYPE html><meta charset="utf-8"><style>html, body, #at, #at * { margin: 0; width: 100%; height: 100%; }</style><div id="at"></div>
<script>${kCommon} window.CESIUM_BASE_URL = '/modules/cesium/Build/Cesium/';</script>
<script src="/modules/cesium/Build/Cesium/Cesium.js"></script>
<script>
(async () => {
  const widget = new Cesium.CesiumWidget('at', { globe: false, skyBox: false, skyAtmosphere: false, baseLayer: false,
    contextOptions: { webgl: { preserveDrawingBuffer: true } } });
  widget.scene.backgroundColor = Cesium.Color.WHITE;
  widget.scene.renderError.addEventListener((scene, e) => tell(e));
  const tileset = await Cesium.Cesium3DTileset.fromUrl('/tiles/tileset.json',
    { maximumScreenSpaceError: 0, cacheBytes: 8e9, cullRequestsWhileMoving: false, foveatedScreenSpaceError: false,
      dynamicScreenSpaceError: false });
  let loaded = 0;
  tileset.tileLoad.addEventListener(() => { ++loaded; });
  tileset.tileFailed.addEventListener((e) => tell(e.url + ': ' + e.message));
  widget.scene.primitives.add(tileset);
  const range = 3.2 * tileset.boundingSphere.radius;
  widget.camera.viewBoundingSphere(tileset.boundingSphere, new Cesium.HeadingPitchRange(0.4, -0.7, range));
  await new Promise((resolve) => tileset.allTilesLoaded.addEventListener(resolve));
  let triangles = 0;
  for (const tile of tileset._selectedTiles) triangles += tile.content.trianglesLength;
  widget.render();
  done({ version: Cesium.VERSION, loaded, triangles }, widget.canvas);
})().catch((e) => { tell(e); done({ loaded: 0 }); });
</script>`;
}

function rendererPage() {
  return `<!DOCTYPE html><meta charset="utf-8"><style>html, body { margin: 0; overflow: hidden; }</style>
<script>${kCommon}</script>
<script type="importmap">{ "imports": { "three": "/modules/three/build/three.module.js", "three/addons/": "/modules/three/examples/jsm/",
  "3d-tiles-renderer": "/modules/3d-tiles-renderer/build/index.js", "3d-tiles-renderer/plugins": "/modules/3d-tiles-renderer/build/index.plugins.js",
  "meshoptimizer": "/modules/meshoptimizer/meshopt_decoder.mjs" } }</script>
<script type="module">
import * as three from 'three';
import { TilesRenderer } from '3d-tiles-renderer';
import { GLTFExtensionsPlugin } from '3d-tiles-renderer/plugins';
import { MeshoptDecoder } from 'meshoptimizer';
const renderer = new three.WebGLRenderer({ preserveDrawingBuffer: true });
renderer.setSize(innerWidth, innerHeight);
document.body.appendChild(renderer.domElement);
const scene = new three.Scene(), camera = new three.PerspectiveCamera(50, innerWidth / innerHeight, 1, 1e8);
scene.background = new three.Color(0xffffff);
scene.add(new three.HemisphereLight(0xffffff, 0x888888, 3));
const tiles = new TilesRenderer('/tiles/tileset.json');
tiles.registerPlugin(new GLTFExtensionsPlugin({ meshoptDecoder: MeshoptDecoder }));
tiles.errorTarget = 0;
tiles.lruCache.maxBytesSize = tiles.lruCache.minBytesSize = 8e9;
let loaded = 0;
tiles.addEventListener('load-model', () => { ++loaded; });
tiles.addEventListener('load-error', (e) => tell(e.url + ': ' + e.error));
tiles.setCamera(camera);
tiles.setResolutionFromRenderer(camera, renderer);
scene.add(tiles.group);
let isPlaced = false, idle = 0; // frames in which nothing was loaded
function frame() {
  const sphere = new three.Sphere();
  if (!isPlaced && tiles.getBoundingSphere(sphere)) {
    const up = sphere.center.length() > 6e6 ? sphere.center.clone().normalize() : new three.Vector3(0, 0, 1);
    const aside = new three.Vector3(1, 0, 0).cross(up).normalize();
    camera.up.copy(up);
    camera.position.copy(sphere.center).addScaledVector(up, 1.7 * sphere.radius).addScaledVector(aside, 1.9 * sphere.radius);
    camera.near = sphere.radius / 100; camera.far = sphere.radius * 100;
    camera.lookAt(sphere.center); camera.updateProjectionMatrix();
    isPlaced = true;
  }
  camera.updateMatrixWorld();
  tiles.update();
  renderer.render(scene, camera);
  const waiting = tiles.stats.queued + tiles.stats.downloading + tiles.stats.parsing;
  idle = isPlaced && loaded > 0 && waiting === 0 ? idle + 1 : 0;
  if (idle < 30) requestAnimationFrame(frame);
  else done({ version: three.REVISION, loaded, triangles: renderer.info.render.triangles }, renderer.domElement);
}
frame();
</script>`;
}

function argumentsOf(words) {
  const asked = { viewer: 'cesium', picture: null, folder: null };
  for (let i = 0; i < words.length; ++i) {
    if (words[i] === '--in') asked.viewer = words[++i];
    else if (words[i] === '--picture') asked.picture = words[++i];
    else asked.folder = words[i];
  }
  return asked;
}

async function main() {
  const asked = argumentsOf(process.argv.slice(2)), viewer = kViewers[asked.viewer];
  if (!viewer || !asked.folder) throw new Error('usage: load_tileset.js [--in cesium|3d-tiles-renderer] [--picture FILE.png] FOLDER');
  const modules = moduleFolder(viewer.modules), program = chromium();
  if (!modules || !program) {
    console.log('SKIPPED: ' + (program ? `${asked.viewer} is not installed (npm install ${viewer.modules.join(' ')})` : 'no chromium'));
    return 77;
  }
  const tileset = JSON.parse(fs.readFileSync(path.join(asked.folder, 'tileset.json'), 'utf8'));
  const facts = (await told(program, viewer.page(), { tiles: asked.folder, modules })).facts;
  if (asked.picture && facts.picture) fs.writeFileSync(asked.picture, Buffer.from(facts.picture.split(',')[1], 'base64'));
  const result = { viewer: asked.viewer, version: facts.version, tiles: tilesOf(tileset.root), loaded: facts.loaded,
                   triangles: facts.triangles, errors: facts.errors };
  console.log(JSON.stringify(result));
  return result.loaded === result.tiles && result.errors.length === 0 ? 0 : 1;
}

main().then((status) => { process.exitCode = status; });
