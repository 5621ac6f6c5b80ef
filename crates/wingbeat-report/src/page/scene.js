// Vectors, the motion of a run, and what is drawn of it: triangles and lines in W (x forward, y left, z up).
const add = (a, b, k = 1) => [a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2]];
const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const norm = a => Math.hypot(a[0], a[1], a[2]);
const unit = a => { const n = norm(a) || 1; return [a[0] / n, a[1] / n, a[2] / n]; };
const mixed = (a, b, s) => a.map((v, i) => v + s * (b[i] - v));
const LIGHT = unit([-0.35, 0.25, 0.9]);
function colour(text, alpha = 1) {
  const hex = text.trim().replace('#', '');
  return [0, 2, 4].map(i => parseInt(hex.slice(i, i + 2), 16) / 255).concat(alpha);
}
const faded = (c, alpha) => [c[0], c[1], c[2], alpha];
// Green where it lifts, purple where it pushes down; strong where it is strong.
function circulationColour(share) {
  const s = Math.max(-1, Math.min(1, share)), base = s >= 0 ? [0.10, 0.55, 0.25] : [0.50, 0.20, 0.60];
  return [...base, 0.05 + 0.5 * Math.abs(s)];
}
class Scene {
  constructor() { this.solid = []; this.glass = []; this.under = []; this.lines = []; }
  tri(list, a, b, c, k) { list.push(a[0], a[1], a[2], k[0], k[1], k[2], k[3], b[0], b[1], b[2], k[0], k[1], k[2], k[3], c[0], c[1], c[2], k[0], k[1], k[2], k[3]); }
  shaded(a, b, c, k) {
    const light = 0.66 + 0.34 * Math.abs(dot(unit(cross(sub(b, a), sub(c, a))), LIGHT));
    this.tri(this.solid, a, b, c, [k[0] * light, k[1] * light, k[2] * light, 1]);
  }
  quad(a, b, c, d, k) { this.shaded(a, b, c, k); this.shaded(a, c, d, k); }
  veil(a, b, c, d, k) { this.tri(this.glass, a, b, c, k); this.tri(this.glass, a, c, d, k); }
  // What the rest is drawn over, however near it is.
  underlay(a, b, c, d, k) { this.tri(this.under, a, b, c, k); this.tri(this.under, a, c, d, k); }
  line(a, b, weight, k) { this.lines.push(a[0], a[1], a[2], b[0], b[1], b[2], weight, k[0], k[1], k[2], k[3]); }
  arrow(a, v, weight, k) {
    const tip = add(a, v), length = norm(v);
    if (!(length > 1e-9)) return;
    const side = unit(cross(v, Math.abs(v[2]) < 0.9 * length ? [0, 0, 1] : [1, 0, 0])), back = add(tip, v, -0.18), over = unit(cross(v, side)), r = 0.06 * length;
    this.line(a, back, weight, k);
    for (const [m, n] of [[side, over], [over, side.map(x => -x)], [side.map(x => -x), over.map(x => -x)], [over.map(x => -x), side]])
      this.tri(this.solid, tip, add(back, m, r), add(back, n, r), k);
  }
}
// The motion of a run: places between frames, a smooth track for the camera, the trailing edges that left the wake.
class Motion {
  constructor(run) {
    Object.assign(this, run.motion);
    this.t = run.axis.values;
    this.n = this.t.length;
    const half = Math.max(0.12, 0.02 * (this.t[this.n - 1] - this.t[0]));
    this.smooth = this.position.map(column => this.averaged(column, half));
    this.heading = new Float64Array(this.n);
    const spread = k => Math.max(...this.smooth[k]) - Math.min(...this.smooth[k]);
    // Who stays at a place is followed by where the nose points, else by the way.
    if (this.free && Math.max(spread(0), spread(1)) < 2 * this.reach) {
      for (let i = 0; i < this.n; i++) { this.seek(this.t[i]); this.heading[i] = Math.atan2(this.R[1][0], this.R[0][0]); }
    } else if (this.free) {
      for (let i = 0; i < this.n; i++) {
        const a = Math.max(0, i - 12), b = Math.min(this.n - 1, i + 12), dx = this.smooth[0][b] - this.smooth[0][a], dy = this.smooth[1][b] - this.smooth[1][a];
        this.heading[i] = Math.hypot(dx, dy) < 1e-3 * this.reach ? (i ? this.heading[i - 1] : 0) : Math.atan2(dy, dx);
      }
    }
    if (this.free) {
      for (let i = 1; i < this.n; i++) this.heading[i] -= 2 * Math.PI * Math.round((this.heading[i] - this.heading[i - 1]) / (2 * Math.PI));
      this.heading = this.averaged(this.heading, half);
    }
    this.low = [Infinity, Infinity, Infinity]; this.high = [-Infinity, -Infinity, -Infinity];
    const tracks = [this.position, ...this.lines.flatMap(line => line.points)];
    for (const track of tracks) for (let k = 0; k < 3; k++) for (const v of track[k]) if (v === v) { this.low[k] = Math.min(this.low[k], v); this.high[k] = Math.max(this.high[k], v); }
    this.most = Math.max(1e-9, ...this.sources.map(source => { let m = 0; for (let i = 0; i < this.n; i++) m = Math.max(m, Math.hypot(...source.force.map(c => c[i]))); return m; }));
    if (this.circulation) this.shed();
    this.camber = this.camberMost();
    this.mostStrip = 1e-9;
    for (const s of this.surfaces) for (const strip of s.strips) if (strip.force) for (let i = 0; i < this.n; i++) this.mostStrip = Math.max(this.mostStrip, Math.hypot(...strip.force.map(c => c[i])));
  }
  averaged(column, half) {
    const sums = new Float64Array(this.n + 1), out = new Float64Array(this.n);
    for (let i = 0; i < this.n; i++) sums[i + 1] = sums[i] + column[i];
    let a = 0, b = 0;
    for (let i = 0; i < this.n; i++) {
      while (this.t[a] < this.t[i] - half) a++;
      while (b < this.n && this.t[b] <= this.t[i] + half) b++;
      out[i] = (sums[b] - sums[a]) / Math.max(1, b - a);
    }
    return out;
  }
  seek(t) {
    const [i, s] = place(this.t, t);
    this.i = i; this.s = s;
    const j = Math.min(i + 1, this.n - 1);
    this.j = j;
    let q = this.attitude.map(c => c[i]), r = this.attitude.map(c => c[j]);
    if (q.reduce((sum, v, k) => sum + v * r[k], 0) < 0) r = r.map(v => -v);
    q = mixed(q, r, s);
    const n = Math.hypot(...q) || 1, [w, x, y, z] = q.map(v => v / n);
    this.R = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]];
    this.p = this.at(this.position);
  }
  at(track) { const { i, j, s } = this; return [0, 1, 2].map(k => track[k][i] + s * (track[k][j] - track[k][i])); }
  // Points along a rib from the leading to the trailing edge, those of a membrane, not of a flap, `size` times as high above its chord as they are.
  along(surface, k, size) {
    const [a, b] = surface.ribs[k].map(edge => this.at(edge)), points = surface.raised ? surface.raised[k] : [];
    return [a, ...points.map((p, n) => { const flat = mixed(a, b, (n + 1) / (points.length + 1)); return mixed(flat, this.at(p), surface.hinge ? 1 : size); }), b];
  }
  // Largest height of a membrane over the chord, of a rib in the middle and of any frame.
  camberMost() {
    let most = 0;
    for (const s of this.surfaces) for (let k = 0; s.raised && !s.hinge && k < s.ribs.length; k++) for (this.i = 0; this.i < this.n; this.i++) {
      this.j = this.i; this.s = 0;
      const [a, b] = s.ribs[k].map(edge => this.at(edge)), chord = norm(sub(b, a));
      if (chord > 1e-3 * this.reach) most = Math.max(most, norm(sub(this.at(s.raised[k][1]), mixed(a, b, 0.5))) / chord);
    }
    return most;
  }
  turned(v) { return this.R.map(row => dot(row, v)); }
  // Half way between the tips: of a half wing not at its root.
  middle() { const ends = this.surfaces.flatMap(s => s.ribs.filter((_, k) => s.covered[k] || s.covered[k - 1])).map(rib => this.at(rib[0])), side = ends.map(p => p[1]); return ends.length ? this.world([0, 0.5 * (Math.min(...side) + Math.max(...side)), 0]) : this.p; }
  world(v, scale = 1) { return add(this.p, this.turned(v), scale); }
  shed() {
    this.rows = this.surfaces.filter(s => s.strips.length > 1).map(surface => {
      const ends = [{ rib: 0 }, ...surface.strips, { rib: surface.ribs.length - 1 }];
      const points = new Float32Array(3 * ends.length * this.n), values = new Float32Array(ends.length * this.n);
      let most = 1e-9;
      for (let i = 0; i < this.n; i++) {
        this.seek(this.t[i]);
        ends.forEach((end, k) => {
          const rib = Math.min(Math.floor(end.rib), surface.ribs.length - 2), share = end.rib - rib;
          const edge = this.world(mixed(this.at(surface.ribs[rib][1]), this.at(surface.ribs[rib + 1][1]), share));
          points.set(edge, 3 * (i * ends.length + k));
          const value = end.circulation ? end.circulation[i] : 0;
          values[i * ends.length + k] = value; most = Math.max(most, Math.abs(value));
        });
      }
      // Nothing is shed into the gap between two halves that no surface covers.
      const open = ends.map((end, k) => k + 1 < ends.length && surface.covered.some((c, r) => !c && r >= Math.floor(end.rib) && r < Math.ceil(ends[k + 1].rib)));
      return { count: ends.length, points, values, open, most };
    });
    this.mostCirculation = Math.max(1e-9, ...this.rows.map(r => r.most));
  }
}
const shown = { wake: true, level: true, strips: false, loop: true, sources: {}, wakeTime: 0.3, camber: 1 };
function addWake(scene, m, coarse) {
  const window = shown.wakeTime, now = m.t[m.i] + m.s * (m.t[m.j] - m.t[m.i]);
  const first = place(m.t, now - window)[0], step = Math.max(1, Math.round((m.i - first) / (coarse ? 16 : 100)));
  for (const row of m.rows) {
    const corner = (i, k) => { const o = 3 * (i * row.count + k), age = now - m.t[i]; return [row.points[o] + age * m.wind[0], row.points[o + 1] + age * m.wind[1], row.points[o + 2] + age * m.wind[2]]; };
    let young = m.i;
    for (let old = m.i - step; old >= Math.max(first, 0); young = old, old -= step) {
      const fade = 1 - 0.75 * (now - m.t[old]) / window;
      for (let k = 0; k + 1 < row.count; k++) {
        if (row.open[k]) continue;
        const mean = 0.25 * (row.values[young * row.count + k] + row.values[young * row.count + k + 1] + row.values[old * row.count + k] + row.values[old * row.count + k + 1]);
        const c = circulationColour(mean / (0.7 * m.mostCirculation));
        c[3] *= fade;
        scene.underlay(corner(young, k), corner(young, k + 1), corner(old, k + 1), corner(old, k), c);
      }
    }
  }
}
// The spindle that stands for the body.
function addBody(scene, m, scale, k) {
  const c = m.at(m.com), [l, r] = m.spindle.size.map(v => v * m.reach * scale), { rings } = m.spindle, around = 7;
  const ring = ([x, w]) => Array.from({ length: around }, (_, n) => { const a = 2 * Math.PI * n / around; return m.world([c[0] * scale + l * x, c[1] * scale + r * w * Math.cos(a), c[2] * scale + r * w * Math.sin(a)]); });
  const points = rings.map(ring);
  for (let i = 0; i + 1 < points.length; i++) for (let n = 0; n < around; n++) scene.quad(points[i][n], points[i][(n + 1) % around], points[i + 1][(n + 1) % around], points[i + 1][n], k);
}
function addRobot(scene, m, look, scale, floor, detailed, table) {
  // A shadow falls on what there is.
  const lit = p => !table || (Math.abs(p[0]) < Math.abs(table[0][0]) && Math.abs(p[1]) < Math.abs(table[0][1]));
  for (const surface of m.surfaces) {
    const ribs = surface.ribs.map(rib => rib.map(edge => m.world(m.at(edge), scale)));
    for (let k = 0; k + 1 < ribs.length; k++) {
      if (!surface.covered[k]) continue;
      const [[a, b], [c, d]] = [ribs[k], ribs[k + 1]], paint = look.sides[surface.side[k]];
      const [one, next] = [k, k + 1].map(n => m.along(surface, n, shown.camber).map(p => m.world(p, scale)));
      for (let n = 0; n + 1 < one.length; n++) {
        scene.quad(one[n], next[n], next[n + 1], one[n + 1], paint);
        if (one.length > 2 && detailed) scene.line(one[n], one[n + 1], 0.8, [paint[0] * 0.45, paint[1] * 0.45, paint[2] * 0.45, 0.6]);
      }
      const dark = [paint[0] * 0.45, paint[1] * 0.45, paint[2] * 0.45, 1];
      scene.line(a, c, 2, dark); scene.line(b, d, 1, dark);
      if (surface.hinge) scene.line(one[surface.hinge], next[surface.hinge], 1, dark);
      if (detailed) scene.line(a, b, 0.8, faded(dark, 0.6));
      if (floor !== undefined && [a, b, c, d].every(lit)) { const down = p => [p[0], p[1], floor]; scene.veil(down(a), down(c), down(d), down(b), [0, 0, 0, 0.28]); }
    }
  }
  if (m.surfaces.length && !m.bare) addBody(scene, m, scale, look.body);
}
function addForces(scene, m, look) {
  const size = 0.9 * m.reach;
  m.sources.forEach((source, n) => {
    const at = m.world(source.place || m.at(m.com));
    if (source.place) scene.arrow(at, m.turned(m.at(source.force)).map(v => v * size / m.most), 3, look.thrust);
    else if (shown.sources[source.name]) scene.arrow(at, m.turned(m.at(source.force)).map(v => v * size / m.most), 3.5, look.sources[m.numbers[n] % look.sources.length]);
  });
  if (!shown.strips) return;
  for (const surface of m.surfaces) for (const strip of surface.strips) {
    if (!strip.force) continue;
    const rib = Math.min(Math.floor(strip.rib), surface.ribs.length - 2), share = strip.rib - rib;
    const edge = n => mixed(m.at(surface.ribs[rib][n]), m.at(surface.ribs[rib + 1][n]), share);
    scene.arrow(m.world(mixed(edge(0), edge(1), 0.25)), m.turned(m.at(strip.force)).map(v => v * size / m.mostStrip), 1.6, look.ink);
  }
}
// The way so far is drawn strongly and stands on a curtain; what is to come is faint.
function addPath(scene, m, look, floor, curtain, pieces = 240) {
  const coarse = Math.max(1, Math.floor(m.n / pieces)), p = i => [m.position[0][i], m.position[1][i], m.position[2][i]];
  // What is near in time is near the eye: there no corner is left out.
  const [from, to] = curtain ? [0, 0] : [-0.8, 0.8].map(s => place(m.t, m.t[m.i] + s)[0]), fine = Math.max(1, Math.floor((to - from) / 160));
  for (let i = 0, j; i + 1 < m.n; i = j) {
    j = Math.min(i + (i >= from && i < to ? fine : coarse), m.n - 1);
    if (i < m.i && j > m.i) j = m.i;
    const done = j <= m.i, a = p(i), b = p(j);
    scene.line(a, b, (done ? 2.6 : 1.4) * (curtain ? 0.7 : 1), done ? look.path : faded(look.path, 0.35));
    if (!curtain) continue;
    scene.veil(a, b, [b[0], b[1], floor], [a[0], a[1], floor], faded(look.path, done ? 0.16 : 0.06));
    scene.line([a[0], a[1], floor], [b[0], b[1], floor], 1.4, faded(look.ink, done ? 0.6 : 0.25));
  }
  const every = Math.pow(10, Math.ceil(Math.log10((m.t[m.n - 1] - m.t[0]) / 10)));
  for (let t = m.t[0]; curtain && t <= m.t[m.n - 1]; t += every / 2) { const a = p(place(m.t, t)[0]); scene.line(a, [a[0], a[1], floor], 1, faded(look.ink, 0.35)); }
}
// Arm and sting, or a perch.
function addLines(scene, m, k) { for (const { points, weight } of m.lines) for (let i = 0; i + 1 < points.length; i++) scene.line(m.at(points[i]), m.at(points[i + 1]), weight, k); }
// A grid under all, which lies on the ground where that is near; a ceiling has one of its own.
function addGround(scene, box, look) {
  const { floor, step, x0, x1, y0, y1, ceiling } = box;
  for (const [z, k] of [[floor, look.grid], [ceiling, faded(look.bound, 0.8)]]) {
    if (z === undefined) continue;
    for (let x = x0; x <= x1 + 1e-9; x += step) scene.line([x, y0, z], [x, y1, z], 1, k);
    for (let y = y0; y <= y1 + 1e-9; y += step) scene.line([x0, y, z], [x1, y, z], 1, k);
  }
  if (ceiling !== undefined) scene.veil([x0, y0, ceiling], [x1, y0, ceiling], [x1, y1, ceiling], [x0, y1, ceiling], faded(look.bound, 0.18));
}
// 1, 2 or 5 times a power of ten, not below `least`.
function round(least) { const power = Math.pow(10, Math.floor(Math.log10(least))); return [1, 2, 5, 10].find(n => n * power >= 0.999 * least) * power; }
// Runs on one page have one scale a kind of arrow, one of circulation, and one colour a source; answers the names of the sources.
function shared(motions) {
  for (const key of ['most', 'mostStrip', 'mostCirculation']) { const most = Math.max(...motions.map(m => m[key] || 1e-9)); for (const m of motions) m[key] = most; }
  const names = [...new Set(motions.flatMap(m => m.sources.filter(s => !s.place).map(s => s.name)))];
  for (const m of motions) m.numbers = m.sources.map(s => names.indexOf(s.name));
  return names;
}
function boxOf(motions) {
  const low = [0, 1, 2].map(k => Math.min(...motions.map(m => m.low[k]))), high = [0, 1, 2].map(k => Math.max(...motions.map(m => m.high[k])));
  const reach = Math.max(...motions.map(m => m.reach)), size = Math.max(2 * reach, ...[0, 1, 2].map(k => high[k] - low[k])), step = round(size / 9);
  const table = motions.map(m => m.table).find(t => t), ground = motions.map(m => m.ground).find(z => typeof z === 'number');
  // A ground is drawn where the runs come within three times their size of it, below or above them.
  const near = ground !== undefined && Math.max(low[2] - ground, ground - high[2]) < 3 * size, below = near && ground <= 0.5 * (low[2] + high[2]), ceiling = near && !below ? ground : undefined;
  const floor = table ? table[0][2] : below ? ground : Math.floor((low[2] - 1.15 * reach) / (0.2 * step) + 1e-6) * 0.2 * step, margin = Math.max(3 * step, 3 * reach);
  const down = v => Math.floor((v - margin) / step) * step, up = v => Math.ceil((v + margin) / step) * step;
  return { low, high, reach, size, step, floor, table, ground, below, ceiling, x0: down(low[0]), x1: up(high[0]), y0: down(low[1]), y1: up(high[1]) };
}
