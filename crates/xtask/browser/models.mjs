// The glTF file of the run `turn` by Khronos's validator: `node models.mjs FOLDER`.
import fs from 'node:fs';
import path from 'node:path';
import { createRequire } from 'node:module';

const folder = path.resolve(process.argv[2]);
const validator = createRequire(path.join(folder, 'node_modules/'))('gltf-validator');
const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(path.join(folder, 'turn.glb'))), { maxIssues: 20 });
const { numErrors, numWarnings } = report.issues;
for (const one of report.issues.messages) console.log(`  ${one.code} ${one.pointer}: ${one.message}`);
const animated = report.info.animationCount === 1;
console.log(`glTF: ${numErrors} errors, ${numWarnings} warnings, ${report.info.totalVertexCount} vertices, ${report.info.animationCount} animation`);
const failed = (numErrors > 0) + !animated;
console.log(`${2 - failed} passed, ${failed} failed`);
process.exit(failed ? 1 : 0);
