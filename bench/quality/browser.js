// A page in headless Chromium, served on the loopback address, that tells what it has found.
'use strict';
const childProcess = require('child_process');
const fs = require('fs');
const http = require('http');
const os = require('os');
const path = require('path');

const kMostMilliseconds = 520e3;

function chromium() {
  const names = ['chromium', 'chromium-browser', 'google-chrome'];
  const folders = (process.env.PATH || '').split(':');
  return folders.flatMap((folder) => names.map((name) => path.join(folder, name))).find((file) => fs.existsSync(file)) || null;
}

const kTypes = { '.js': 'text/javascript', '.mjs': 'text/javascript', '.json': 'application/json', '.wasm': 'application/wasm',
                 '.css': 'text/css', '.glb': 'model/gltf-binary' };

/// Answers with the page, with files of the folders (by name; '': those of no folder), and takes
/// what the page tells. Counts the bytes of files that it has sent.
function serve(page, folders, sent, whenDone) {
  const server = http.createServer((request, response) => {
    const name = decodeURIComponent(new URL(request.url, 'http://localhost').pathname);
    if (name === '/') { response.setHeader('Content-Type', 'text/html'); response.end(page); return; }
    if (name === '/done') {
      const parts = [];
      request.on('data', (part) => parts.push(part));
      request.on('end', () => { response.end(); whenDone(JSON.parse(Buffer.concat(parts).toString())); });
      return;
    }
    if (name === '/sent') { response.end(String(sent.bytes)); return; }
    const [, ...words] = name.split('/');
    const folder = words.length > 1 ? words[0] : '', rest = words.length > 1 ? words.slice(1) : words;
    const file = folders[folder] && path.join(folders[folder], ...rest);
    if (!file || rest.includes('..') || !fs.existsSync(file)) { response.statusCode = 404; response.end(); return; }
    response.setHeader('Content-Type', kTypes[path.extname(file)] || 'application/octet-stream');
    sent.bytes += fs.statSync(file).size;
    fs.createReadStream(file).pipe(response);
  });
  return new Promise((resolve) => server.listen(0, '127.0.0.1', () => resolve(server)));
}

/// What the page tells when it is done, and how many bytes of files were sent.
async function told(program, page, folders, address = '/') {
  const profile = fs.mkdtempSync(path.join(os.tmpdir(), 'orbweave-viewer-'));
  let browser = null, server = null, timer = null;
  const sent = { bytes: 0 };
  try {
    const facts = await new Promise((resolve, reject) => {
      timer = setTimeout(() => resolve({ loaded: 0, errors: ['nothing was told in time'] }), kMostMilliseconds);
      serve(page, folders, sent, resolve).then((started) => {
        server = started;
        browser = childProcess.spawn(program, ['--headless=new', '--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
          '--no-first-run', '--window-size=1280,800', `--user-data-dir=${profile}`, `http://127.0.0.1:${server.address().port}${address}`],
          { stdio: 'ignore' });
        browser.on('error', reject);
        browser.on('exit', (status) => resolve({ loaded: 0, errors: [`the browser ended with status ${status}`] }));
      }, reject);
    });
    return { facts, bytes: sent.bytes };
  } finally {
    clearTimeout(timer);
    if (server) { server.close(); server.closeAllConnections(); }
    if (browser && browser.exitCode === null) {
      await new Promise((resolve) => { browser.removeAllListeners(); browser.on('exit', resolve); browser.kill(); });
    }
    fs.rmSync(profile, { recursive: true, force: true, maxRetries: 5 });
  }
}

module.exports = { chromium, told };
