// The glTF file of the run `turn` by Khronos's validator, and in three.js, whose animated wings are held against the frames for VTK:
// `node models.mjs FOLDER`.
import fs from 'node:fs';
import path from 'node:path';
import { createRequire } from 'node:module';
import { pathToFileURL } from 'node:url';

const folder = path.resolve(process.argv[2]), require = createRequire(path.join(folder, 'node_modules/'));
const bytes = fs.readFileSync(path.join(folder, 'turn.glb'));
let passed = 0, failed = 0;
const judge = (name, holds, value) => { holds ? passed++ : failed++; console.log(`${name}: ${value}${holds ? '' : '  FAILED'}`); };

const report = await require('gltf-validator').validateBytes(new Uint8Array(bytes), { maxIssues: 20 });
const { numErrors, numWarnings } = report.issues;
for (const one of report.issues.messages) console.log(`  ${one.code} ${one.pointer}: ${one.message}`);
judge("Khronos's validator", numErrors === 0 && numWarnings === 0, `${numErrors} errors, ${numWarnings} warnings, ${report.info.totalVertexCount} vertices`);
judge('animations', report.info.animationCount === 1, report.info.animationCount);

// What three.js wants of a browser.
globalThis.self = globalThis;
const three = await import(pathToFileURL(require.resolve('three')).href.replace('three.cjs', 'three.module.js'));
const { GLTFLoader } = await import(pathToFileURL(path.join(folder, 'node_modules/three/examples/jsm/loaders/GLTFLoader.js')).href);
const model = await new Promise((done, lost) => new GLTFLoader().parse(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length), '', done, lost));
const mixer = new three.AnimationMixer(model.scene), action = mixer.clipAction(model.animations[0]), skinned = [];
action.setLoop(three.LoopOnce); action.clampWhenFinished = true; action.play();
model.scene.traverse(node => node.isSkinnedMesh && skinned.push(node));
judge('skinned meshes in three.js', skinned.length > 0, skinned.length);
const frames = JSON.parse(fs.readFileSync(path.join(folder, 'turn-vtk/frames.vtk.series'))).files;
judge('length of the animation in three.js', Math.abs(model.animations[0].duration - (frames.at(-1).time - frames[0].time)) < 1e-3, `${model.animations[0].duration} s`);
let farthest = 0, moved = 0, first;
for (const frame of [0, 0.23, 0.5, 0.77, 1].map(share => frames[Math.round(share * (frames.length - 1))])) {
  mixer.setTime(frame.time - frames[0].time);
  model.scene.updateMatrixWorld(true);
  const lines = fs.readFileSync(path.join(folder, 'turn-vtk', frame.name), 'utf8').split('\n'), head = lines.findIndex(line => line.startsWith('POINTS'));
  const corners = new Set(lines.filter(line => line.startsWith('4 ')).flatMap(line => line.split(' ').slice(1)));
  const points = [...corners].map(n => lines[head + 1 + +n].split(' ').map(Number)), p = new three.Vector3(), seen = [];
  for (const mesh of skinned) {
    mesh.skeleton.update();
    for (let i = 0; i < mesh.geometry.attributes.position.count; i++) { mesh.getVertexPosition(i, p); p.applyMatrix4(mesh.matrixWorld); seen.push([p.x, -p.z, p.y]); }
  }
  for (const a of points) farthest = Math.max(farthest, Math.min(...seen.map(b => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]))));
  first ??= points; moved = Math.max(moved, Math.hypot(...points[0].map((v, k) => v - first[0][k])));
}
judge('edges of the wings in three.js, farthest from those for VTK', farthest < 1e-5, `${farthest} m`);
judge('they move', moved > 1, `${moved} m`);
console.log(`${passed} passed, ${failed} failed`);
process.exit(failed ? 1 : 0);
