// Runs Khronos' gltf-validator over GLB files, and over all GLB files of folders.
//
//   npm install gltf-validator        (anywhere; NODE_PATH or the current folder leads to it)
//   node bench/quality/validate_gltf.js FILE.glb|FOLDER ...
//
// Prints one line of JSON: files, errors, warnings, and the first messages. Exit status 0: no error
// in any file; 1: errors; 77: the validator is not installed.
'use strict';
const fs = require('fs');
const path = require('path');
const { createRequire } = require('module');

function validatorOf() {
  for (const base of [__filename, path.join(process.cwd(), 'package.json'),
                      ...(process.env.NODE_PATH || '').split(':').filter(Boolean)
                          .map((folder) => path.join(folder, 'package.json'))]) {
    try {
      return createRequire(base)('gltf-validator');
    } catch (error) {
      if (error.code !== 'MODULE_NOT_FOUND') throw error;
    }
  }
  // Folders of NODE_PATH hold modules themselves.
  for (const folder of (process.env.NODE_PATH || '').split(':').filter(Boolean)) {
    const module = path.join(folder, 'gltf-validator');
    if (fs.existsSync(module)) return require(module);
  }
  return null;
}

function glbFiles(name) {
  if (!fs.statSync(name).isDirectory()) return [name];
  return fs.readdirSync(name).sort().filter((file) => file.endsWith('.glb'))
      .map((file) => path.join(name, file));
}

async function main() {
  const validator = validatorOf();
  if (!validator) {
    console.log('SKIPPED: gltf-validator is not installed (npm install gltf-validator)');
    return 77;
  }
  const sum = { validator: validator.version(), files: 0, errors: 0, warnings: 0, messages: [] };
  for (const file of process.argv.slice(2).flatMap(glbFiles)) {
    const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)),
                                                 { maxIssues: 100, writeTimestamp: false });
    sum.files += 1;
    sum.errors += report.issues.numErrors;
    sum.warnings += report.issues.numWarnings;
    for (const message of report.issues.messages)
      if (message.severity < 2 && sum.messages.length < 10)
        sum.messages.push(`${file}: ${message.code} ${message.pointer}: ${message.message}`);
  }
  console.log(JSON.stringify(sum));
  return sum.errors > 0 || sum.files === 0 ? 1 : 0;
}

main().then((status) => { process.exitCode = status; });
