'use strict';
// Numbers of the page: `value = step (base + q - 1)`, q = 0 where there is none; q by differences, one plane of bytes after the other.
const $ = id => document.getElementById(id);
const make = (name, attributes, ...children) => {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes || {})) value !== undefined && element.setAttribute(key, value);
  element.append(...children);
  return element;
};
async function inflated(letters) {
  if (typeof DecompressionStream === 'undefined') throw new Error('this browser cannot inflate (DecompressionStream is missing); use one of 2023 or later');
  const text = atob(letters.trim()), bytes = new Uint8Array(text.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = text.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate-raw'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
function column(bytes, { at, rows, base, step, order, planes }, Kind = Float32Array) {
  const q = new Float64Array(rows);
  let power = 1;
  for (let plane = 0; plane < planes; plane++, power *= 256) {
    const base = at + plane * rows;
    for (let i = 0; i < rows; i++) q[i] += bytes[base + i] * power;
  }
  for (let i = 0; i < rows; i++) q[i] = q[i] % 2 ? -(q[i] + 1) / 2 : q[i] / 2;
  for (let k = 0; k < order; k++) for (let i = 1; i < rows; i++) q[i] += q[i - 1];
  const out = new Kind(rows);
  for (let i = 0; i < rows; i++) out[i] = q[i] ? step * (base + q[i] - 1) : NaN;
  // What the values are multiples of.
  out.step = step;
  return out;
}
// Every channel below `value` in its place.
function decoded(bytes, value) {
  if (Array.isArray(value)) return value.map(part => decoded(bytes, part));
  if (value && typeof value === 'object') {
    if ('planes' in value) return column(bytes, value);
    return Object.fromEntries(Object.entries(value).map(([key, part]) => [key, decoded(bytes, part)]));
  }
  return value;
}
function read(bytes, data) {
  const length = new DataView(bytes.buffer).getUint32(0, true), runs = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
  bytes = bytes.subarray(4 + length);
  return runs.map(({ axis, ...run }, k) => ({ ...data.runs[k], ...decoded(bytes, run), axis: { ...axis, values: column(bytes, axis.values, Float64Array) } }));
}
// Columns with those of `more` behind them; all else as it is said last.
function longer(there, more) {
  if (more === undefined) return there;
  if (ArrayBuffer.isView(there)) { const all = new there.constructor(there.length + more.length); all.set(there); all.set(more, there.length); return all; }
  if (Array.isArray(there)) return there.map((part, k) => longer(part, more[k]));
  if (there && typeof there === 'object') return Object.fromEntries(Object.keys(there).map(key => [key, longer(there[key], more[key])]));
  return more;
}
// Where `t` lies in the ascending `values`: row and share of the way to the next.
function place(values, t) {
  const last = values.length - 1;
  if (!(t > values[0])) return [0, 0];
  if (t >= values[last]) return [last, 0];
  let low = 0, high = last;
  while (high - low > 1) { const middle = (low + high) >> 1; values[middle] <= t ? low = middle : high = middle; }
  return [low, (t - values[low]) / (values[high] - values[low] || 1)];
}
const digits = value => !Number.isFinite(value) ? '–' : value === 0 ? '0' : (Math.abs(value) >= 1e5 || Math.abs(value) < 1e-3 ? value.toExponential(2) : String(+value.toPrecision(4))).replace('-', '−');
