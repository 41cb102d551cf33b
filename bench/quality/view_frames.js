// What a folder of "orbweave view --folder" loads, and how fast it turns, in headless Chromium.
//
//   node bench/quality/view_frames.js [--hash FIELDS] [--query FIELDS] [--load SECONDS] [--picture FILE.png] FOLDER
//
// FIELDS are those of a link: "colors=patches&axis=0&cut=400", and "error=0.5" of its query. After SECONDS (15) of loading the mesh is turned for ten
// seconds; each frame is waited for. Prints one line of JSON: bytes before the first picture, bytes in all, tiles and triangles
// that are drawn, frames per second. Exit status 0: a picture was drawn; 1: not so; 77: Chromium is not installed.
'use strict';
const fs = require('fs');
const path = require('path');
const { chromium, told } = require('./browser.js');

/// In the page, behind the viewer's own script.
function drive(seconds) {
  const canvas = document.querySelector('canvas'), root = document.documentElement;
  const wait = (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds));
  const frame = () => new Promise((resolve) => requestAnimationFrame(resolve));
  const gl = canvas.getContext('webgl2'), pixel = new Uint8Array(4);
  const facts = { errors: [] };
  canvas.setPointerCapture = () => {};
  const point = (type, x) => canvas.dispatchEvent(
    new PointerEvent(type, { pointerId: 1, clientX: x, clientY: 300, buttons: 1, bubbles: true }));
  const turn = async (x) => {
    const before = root.dataset.frames;
    point('pointermove', x);
    while (root.dataset.frames === before) await frame();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
  };
  return (async () => {
    const begin = performance.now();
    while (!root.dataset.drawn || root.dataset.drawn === '0') await wait(20);
    facts.first_bytes = Number(await (await fetch('/sent')).text());
    facts.first_seconds = (performance.now() - begin) / 1000;
    await wait(1000 * seconds);
    point('pointerdown', 400);
    const from = performance.now();
    let frames = 0;
    for (; performance.now() - from < 10000; ++frames) await turn(400 + 8 * (frames + 1));
    facts.frames_per_second = frames / ((performance.now() - from) / 1000);
    await turn(401);
    facts.tiles = Number(root.dataset.drawn);
    facts.triangles = Number(root.dataset.triangles);
    facts.picture = canvas.toDataURL('image/png');
    facts.said = document.getElementById('tape').textContent;
    facts.trouble = root.dataset.trouble || null;
    await fetch('/done', { method: 'POST', body: JSON.stringify(facts) });
  })();
}

async function main() {
  const asked = { hash: '', query: '', load: 15, picture: null, folder: null };
  for (let words = process.argv.slice(2); words.length > 0;) {
    const word = words.shift();
    if (word.startsWith('--')) asked[word.slice(2)] = words.shift();
    else asked.folder = word;
  }
  if (!asked.folder) throw new Error('usage: view_frames.js [--hash FIELDS] [--query FIELDS] [--load SECONDS] [--picture FILE.png] FOLDER');
  const program = chromium();
  if (!program) { console.log('SKIPPED: no chromium'); return 77; }
  const page = fs.readFileSync(path.join(asked.folder, 'index.html'), 'utf8');
  const { facts, bytes } = await told(program, page + `<script>(${drive})(${Number(asked.load)})</script>`, { '': asked.folder },
                                      `/?${asked.query}#${asked.hash}`);
  if (asked.picture && facts.picture) fs.writeFileSync(asked.picture, Buffer.from(facts.picture.split(',')[1], 'base64'));
  console.log(JSON.stringify({ ...facts, first_bytes: facts.first_bytes + Buffer.byteLength(page), bytes: bytes + Buffer.byteLength(page),
                               picture: undefined }));
  return facts.tiles > 0 && !facts.trouble ? 0 : 1;
}

main().then((status) => { process.exitCode = status; });
