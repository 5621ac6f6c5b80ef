// The picture in space: what of the runs is drawn, from where, and when.
const VIEWS = { chase: { azimuth: 0, elevation: 0.25 }, follow: { azimuth: -0.7, elevation: 0.3 }, whole: { azimuth: 0.5, elevation: 0.42 }, side: { azimuth: Math.PI / 2, elevation: 0.06 }, top: { azimuth: 0, elevation: 1.5 } };
const limited = (v, low, high) => Math.max(low, Math.min(high, v));
class Stage {
  constructor(mark) {
    Object.assign(this, { mark, canvas: $('space'), overlay: new Overlay($('marks')), camera: new Camera(), frames: 0, slow: 0, quality: 1, low: 0, high: 0, motions: [], shots: [] });
    this.state = { t: 0, playing: false, speed: 1, dirty: true };
    this.view = { mode: '', azimuth: 0, elevation: 0.24, zoom: 1, shift: [0, 0, 0] };
    this.still = matchMedia('(prefers-reduced-motion: reduce)');
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { this.relook(); this.frame(); });
    // A canvas that once drew with WebGL draws in no other way: the page begins again at its time with the other one.
    this.canvas.addEventListener('webglcontextlost', () => { location.hash = '2d&t=' + this.state.t.toFixed(3); location.reload(); });
    new ResizeObserver(() => { this.state.dirty = true; this.frame(); }).observe(this.canvas);
  }
  get span() { return this.high - this.low; }
  get free() { return this.motions.some(m => m.free); }
  get flat() { return this.renderer.kind === 'canvas'; }
  // Takes runs in place of those before; the view stays, and the time unless the page goes with a computation.
  load(motions, shots, plots) {
    const first = !this.renderer && (motions.length || shots.length), at = this.state.t >= this.high - 1e-9;
    Object.assign(this, { motions, shots, plots, fits: new Map() });
    this.named = shared(motions);
    [this.low, this.high] = shots.length ? [0, shots.length - 1] : [plots.low, plots.high];
    if (motions.length || shots.length) {
      this.box = motions.length ? boxOf(motions) : boxOfShots(shots);
      if (first) { this.begin(); this.choose(this.usual()); if (this.shots.length) this.view.azimuth = -1; }
      this.relook();
    }
    this.seek(this.follows && at ? this.high : first || !this.renderer ? this.low : this.state.t);
    this.frame();
  }
  usual() { return this.free ? 'chase' : this.box.table || this.shots.length ? 'whole' : 'follow'; }
  // WebGL 2, or a canvas where there is none.
  begin() {
    try {
      if (location.hash.includes('2d')) throw new Error('asked for');
      const probe = document.createElement('canvas').getContext('webgl2'), info = probe && probe.getExtension('WEBGL_debug_renderer_info');
      this.soft = !!info && /swiftshader|llvmpipe|software/i.test(probe.getParameter(info.UNMASKED_RENDERER_WEBGL));
      if (probe && probe.getExtension('WEBGL_lose_context')) probe.getExtension('WEBGL_lose_context').loseContext();
      this.renderer = new Gl(this.canvas, this.soft);
    } catch { this.renderer = new Flat(this.canvas); }
    if (this.soft || this.flat) this.quality = 0.7;
  }
  relook() {
    const style = getComputedStyle(document.documentElement), of = name => colour(style.getPropertyValue(name));
    this.look = { sky: of('--sky'), ground: of('--ground'), grid: of('--grid'), ink: of('--ink'), path: of('--ink'), body: [0.42, 0.45, 0.5, 1], thrust: of('--c3'),
      floor: this.shots.length || !this.box ? undefined : this.box.floor, sides: [colour('#0072b2'), colour('#d55e00'), [0.55, 0.58, 0.62, 1]], sources: [0, 1, 2, 3, 4, 5, 6, 7].map(n => of('--c' + n)) };
    this.overlay.relook(style);
    if (this.box && this.box.below) [this.look.ground, this.look.grid] = [of('--soil'), of('--furrow')];
    this.look.bound = of('--furrow'); this.look.wind = of('--quiet');
    this.state.dirty = true;
  }
  // The colours of run number `k`: those of later runs are paler; of several each has a path in the colour of its plots.
  looks(k) {
    const tinted = c => k ? [...mixed(c.slice(0, 3), [1, 1, 1], 0.35 * Math.min(k, 2)), c[3]] : c;
    return { ...this.look, sides: this.look.sides.map(tinted), path: this.motions.length > 1 ? this.look.sources[ofRun(k)] : this.look.path };
  }
  choose(mode) {
    Object.assign(this.view, { mode, zoom: 1, shift: [0, 0, 0] }, VIEWS[mode]);
    if (mode === 'whole' && this.free) this.view.azimuth = this.across();
    document.querySelectorAll('[data-camera]').forEach(b => b.setAttribute('aria-pressed', b.dataset.camera === mode));
    this.state.dirty = true;
  }
  aim() {
    const { view, camera, box } = this, m = this.motions[0], whole = ['whole', 'side', 'top'].includes(view.mode) || !m;
    const heading = m ? mixed([m.heading[m.i]], [m.heading[m.j]], m.s)[0] : 0;
    camera.azimuth = (view.mode === 'chase' ? heading : 0) + view.azimuth;
    camera.elevation = limited(view.elevation, -1.5, 1.5);
    if (!whole) { camera.target = add(m.free ? m.at(m.smooth) : m.middle(), view.shift); camera.distance = 5 * box.reach * view.zoom; return; }
    camera.target = this.middle();
    this.fit(camera, this.size[0] / this.size[1]);
    camera.target = add(camera.target, view.shift); camera.distance *= view.zoom;
  }
  // From where a whole way is seen: one that bends from behind its begin, so that right is right; a straight one more from its side.
  across() {
    const [x, y] = this.motions[0].smooth, n = x.length, dx = x[n - 1] - x[0], dy = y[n - 1] - y[0], length = Math.hypot(dx, dy);
    let aside = 0;
    for (let i = 0; i < n; i++) aside = Math.max(aside, Math.abs((x[i] - x[0]) * dy - (y[i] - y[0]) * dx) / (length || 1));
    return length > 2 * this.box.reach && aside < 0.1 * length ? Math.atan2(dy, dx) + 0.95 : 0.5;
  }
  middle() { const { low, high, floor } = this.box; return [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (floor + high[2])]; }
  // What has to be seen: the whole way with the robot on it and its foot on the ground, arms, the box of a wake.
  corners(enlarged) {
    const { box } = this, r = box.reach * enlarged, corners = [];
    for (const run of this.motions) for (let k = 0; k <= 24; k++) {
      const i = Math.round(k * (run.n - 1) / 24), p = run.position.map(c => c[i]);
      corners.push([p[0], p[1], box.floor], ...[[r, 0, 0], [-r, 0, 0], [0, r, 0], [0, -r, 0], [0, 0, r]].map(d => add(p, d)));
    }
    for (const run of this.motions) for (const line of run.lines) for (const point of line.points) corners.push(point.map(c => c[0]), point.map(c => c[run.n - 1]));
    for (let k = 0; this.shots.length && k < 8; k++) corners.push([0, 1, 2].map(a => (k >> a & 1 ? box.high : box.low)[a]));
    return corners;
  }
  // The least distance from which the corners are seen, and the target that centres them; what was found once is kept.
  fit(cam, aspect, enlarged = 1) {
    const key = [cam.azimuth, cam.elevation, aspect, enlarged].map(v => v.toFixed(4)).join(), known = this.fits.get(key);
    if (known) { Object.assign(cam, { target: known[0], distance: known[1] }); return; }
    const corners = this.corners(enlarged);
    cam.distance = 4 * this.box.size;
    for (let turn = 0; turn < 24; turn++) {
      const m = cam.matrix(aspect), q = corners.map(p => transformed(m, p));
      // Nothing may lie behind the eye, or so near before it that it hides the rest.
      if (Math.min(...q.map(p => p[3])) < 0.08 * cam.distance) { cam.distance *= 1.3; continue; }
      const seen = q.map(p => [p[0] / p[3], p[1] / p[3]]), range = k => [Math.min(...seen.map(s => s[k])), Math.max(...seen.map(s => s[k]))], [x, y] = [range(0), range(1)];
      const half = cam.distance * Math.tan(cam.fov / 2), share = limited(Math.max(x[1] - x[0], y[1] - y[0]) / 2 / 0.88, 0.7, 1.5), slow = 0.7;
      cam.target = add(add(cam.target, cam.right, slow * 0.5 * (x[0] + x[1]) * half * Math.max(1, aspect)), cam.up, slow * 0.5 * (y[0] + y[1]) * half / Math.min(1, aspect));
      cam.distance *= share;
    }
    if (this.fits.size > 50) this.fits.clear();
    this.fits.set(key, [cam.target, cam.distance]);
  }
  seek(t) {
    const { state, shots } = this;
    state.t = limited(t, this.low, this.high);
    const shot = shots[Math.round(state.t)];
    this.mark(shot ? shot.time : state.t);
    $('scrub').value = this.span ? 1000 * (state.t - this.low) / this.span : 0;
    const text = shot ? shot.name : `${state.t.toFixed(3)} s of ${this.high.toFixed(2)} s`.replace('-', '−');
    $('clock').textContent = text; $('scrub').setAttribute('aria-valuetext', text);
    state.dirty = true;
  }
  play(on) {
    if (on && this.state.t >= this.high - 1e-9) this.seek(this.low);
    this.state.playing = on; this.state.last = undefined;
    $('play').textContent = on ? '❚❚' : '▶'; $('play').setAttribute('aria-label', on ? 'Pause' : 'Play');
    if (on) requestAnimationFrame(now => this.tick(now));
    // The frame at which it rests is the one that is sharpened.
    else { this.state.dirty = true; requestAnimationFrame(() => this.frame()); }
  }
  tick(now) {
    const { state } = this;
    if (!state.playing) return;
    if (state.last !== undefined) {
      let t = state.t + Math.min(0.25, (now - state.last) / 1000) * (this.shots.length ? 1.2 * state.speed : state.speed);
      if (t > this.high && !shown.loop) { this.seek(this.high); this.play(false); return; }
      if (t > this.high) t = this.low + (t - this.high) % (this.span || 1);
      this.seek(t); this.adapt(now - state.last);
    }
    state.last = now;
    this.frame();
    requestAnimationFrame(next => this.tick(next));
  }
  // A slow machine gets fewer pixels.
  adapt(ms) { this.slow = ms > 34 ? this.slow + 1 : Math.max(0, this.slow - 0.5); if (this.slow > 12 && this.quality > 0.45) { this.quality *= 0.8; this.slow = 0; } }
  // Pixels in one of the page: fewer while a slow machine moves, and all as soon as the picture rests.
  ratio() {
    const dense = Math.min(2, devicePixelRatio || 1), { state } = this;
    clearTimeout(this.rest);
    if (this.sharp && !state.playing) return this.soft ? 2 : dense;
    if (!state.playing && !this.follows) this.rest = setTimeout(() => this.sharpen(), 200);
    return (this.soft || this.flat ? 1 : dense) * this.quality;
  }
  // Of a page on paper, which hides the canvas itself, a size that fits there.
  get size() { const { clientWidth, clientHeight } = this.canvas; return this.paper && !clientWidth ? [960, 540] : [clientWidth, clientHeight]; }
  sharpen() { if (!this.state.playing) { this.sharp = true; this.state.dirty = true; this.frame(); this.sharp = false; } }
  frame() {
    const { state, canvas } = this, [w, h] = this.size;
    if (!state.dirty || !this.renderer || this.plots.printing || !(this.motions.length || this.shots.length) || !w || !h) return;
    state.dirty = false; this.frames++;
    const ratio = this.ratio(), W = Math.max(2, Math.round(w * ratio)), H = Math.max(2, Math.round(h * ratio));
    if (canvas.width !== W || canvas.height !== H) { canvas.width = W; canvas.height = H; }
    this.overlay.begin(w, h);
    if (this.shots.length) this.drawShot(W, H, ratio); else this.drawMotions(w, h, W, H, ratio);
    this.overlay.put(w, h);
  }
  drawMotions(w, h, W, H, ratio) {
    const { box, look, view, camera } = this, ground = new Scene(), scene = new Scene(), near = ['chase', 'follow'].includes(view.mode);
    if (box.table) ground.quad(...box.table, look.grid); else addGround(ground, box, look);
    this.motions.forEach((m, k) => { m.seek(this.state.t); this.addRun(scene, m, this.looks(k)); });
    this.aim();
    this.renderer.pass([ground, scene], camera, [0, 0, W, H], look, ratio);
    if (!near) this.labels(camera, [0, 0, w, h]);
    if (box.table) this.overlay.write(`table ${digits(+norm(sub(box.table[1], box.table[0])).toPrecision(3))} m wide`, 8, h - 8);
    this.name(camera, w, h);
    if (this.free && near && w > 330) this.drawCorner(ground, w, h, ratio);
    this.overlay.legend(w, h, this.motions, shown.level && this.free, box);
  }
  addRun(scene, m, own) {
    const { box, look, view } = this;
    if (m.free) addPath(scene, m, own, box.floor, view.mode === 'whole' || view.mode === 'side');
    if (m.path) for (let i = 0, step = Math.max(1, Math.floor(m.n / 200)); i + step < m.n; i += 2 * step) scene.line(m.path.map(c => c[i]), m.path.map(c => c[i + step]), 1.6, faded(look.thrust, 0.8));
    if (shown.wake && m.circulation) addWake(scene, m, this.flat);
    addRobot(scene, m, own, 1, box.floor, !this.flat, box.table);
    addLines(scene, m, look.body);
    addForces(scene, m, own);
    if (!box.table) scene.line(m.p, [m.p[0], m.p[1], box.floor], 1, faded(look.ink, 0.4));
    if (shown.level && m.free) addLevel(scene, m, own);
    if (!m.free && norm(m.wind)) { const along = unit(m.wind); scene.arrow(add(m.middle(), along, -2.2 * m.reach), along.map(v => 0.7 * m.reach * v), 3, look.wind); }
  }
  // What is written beside lines that stand in space, where the corner does not hide it.
  name(cam, w, h) {
    const m = cam.matrix(w / h), [pad, iw, ih] = this.corner(w, h), write = (text, point, align) => {
      const q = transformed(m, point), u = w * (0.5 + 0.5 * q[0] / q[3]), v = h * (0.5 - 0.5 * q[1] / q[3]);
      if (q[3] > 0 && u > 9 && u < w - (align ? 9 : 40) && v > 13 && v < h && (u > pad + iw + 6 || v < h - pad - ih - 6)) this.overlay.write(text, align ? u : u + 6, v + 4, align);
    };
    if (this.motions.length > 1) this.motions.forEach(run => write(run.run.name, add(run.p, cam.up, 1.1 * run.reach), 'center'));
    const f = this.motions[0];
    if (shown.level && f.free) for (const k of [0, 1]) write('LR'[k], add(add(f.world(f.at(f.com)), f.turned([0, 1, 0]), (k ? -1.4 : 1.4) * f.reach), cam.up, 0.14 * f.reach), 'center');
    for (const line of f.lines) if (line.name === 'perch') write('perch', f.at(line.points[line.points.length - 1]));
  }
  // The whole way in a corner, the robot enlarged.
  corner(w, h) { return [8, Math.round(0.29 * w), Math.round(0.37 * h)]; }
  drawCorner(ground, w, h, ratio) {
    const { box } = this, [pad, iw, ih] = this.corner(w, h), small = new Scene(), inset = Object.assign(new Camera(), this.camera), enlarged = m => limited(0.11 * box.size / m.reach, 1, 12);
    this.motions.forEach((m, k) => { const own = this.looks(k); addPath(small, m, own, box.floor, true, 120); addRobot(small, m, own, enlarged(m), box.floor, false); addLines(small, m, own.body); });
    Object.assign(inset, { target: this.middle(), azimuth: this.across() - 0.15, elevation: 0.36 });
    this.fit(inset, iw / ih, Math.max(...this.motions.map(enlarged)));
    this.renderer.pass([ground, small], inset, [pad, pad, iw, ih].map(v => Math.round(v * ratio)), this.look, ratio);
    this.overlay.patch('', pad, h - pad - ih, iw, ih);
    if (iw > 230) this.labels(inset, [pad, h - pad - ih, iw, ih]);
  }
  // Start and end of the way, and the size of the grid.
  labels(cam, [x, y, w, h]) {
    const { box } = this, m = cam.matrix(w / h);
    if (box.table || !this.free) return;
    const several = this.motions.length > 1;
    const own = this.motions[0];
    let before;
    for (const [i, word] of several ? [] : [[0, 'start'], [own.n - 1, 'end']]) {
      const p = own.position.map(c => c[i]), q = transformed(m, p);
      if (q[3] <= 0) continue;
      const u = x + w * (0.5 + 0.5 * q[0] / q[3]), at = limited(u, x + 44, x + w - 44);
      let v = Math.max(y + 14, y + h * (0.5 - 0.5 * q[1] / q[3]) - 10);
      if (before && Math.abs(before[0] - at) < 84 && Math.abs(before[1] - v) < 17) v = before[1] + (v < before[1] && before[1] > y + 32 ? -17 : 17);
      if (u < x || u > x + w || v > y + h - 24) continue;
      before = [at, v];
      this.overlay.write(`${word} ${digits(+(p[2] - box.floor).toFixed(2))} m`, at, v, 'center');
    }
    const above = ', heights above ' + (box.below ? 'ground' : 'it');
    this.overlay.write('grid ' + digits(box.step) + ' m' + (several ? '' : above), x + 8, y + h - 8);
  }
  drawShot(W, H, ratio) {
    const { box, camera } = this, shot = this.shots[Math.round(this.state.t)], scene = new Scene(), [w, h] = this.size;
    // A hundredth of the rings is stronger than the scale, which so is not that of one curled-up edge.
    const sizes = shot.circulation.slice(shot.wings).map(Math.abs).sort((a, b) => a - b), most = Math.max(1e-9, sizes[Math.floor(0.99 * (sizes.length - 1))] || 0);
    const corner = i => shot.corners.map(c => c[i]);
    shot.circulation.forEach((value, n) => {
      const [a, b, c, d] = [0, 1, 2, 3].map(k => corner(4 * n + k));
      if (n < shot.wings) { scene.quad(a, b, c, d, this.look.sides[0.25 * (a[1] + b[1] + c[1] + d[1]) >= 0 ? 0 : 1]); return; }
      // Many sheets lie over one another.
      if (shown.wake) { const k = circulationColour(value / most); k[3] *= 0.45; scene.veil(a, b, c, d, k); }
    });
    const { low, high, step } = box, from = [low[0], low[1], low[2]], bar = add(from, [step, 0, 0]);
    scene.line(from, bar, 3, this.look.ink);
    this.aim();
    this.renderer.pass([scene], camera, [0, 0, W, H], this.look, ratio);
    const q = transformed(camera.matrix(w / h), add(from, [0.5 * step, 0, 0]));
    if (q[3] > 0) this.overlay.write(`${digits(step)} m`, w * (0.5 + 0.5 * q[0] / q[3]), h * (0.5 - 0.5 * q[1] / q[3]) + 18, 'center');
    this.overlay.write(`${shot.name}, t = ${digits(shot.time)} s`, 10, 20);
    this.overlay.sides(w, shot.corners[1].slice(0, 4 * shot.wings));
    if (shown.wake) this.overlay.scale(w, h, most, 'circulation of the rings, m²/s');
  }
  // A canvas that was drawn just now is not yet on paper; a copy of it is.
  copy() {
    const sheet = $('sheet'), c = sheet.getContext('2d');
    sheet.width = this.canvas.width; sheet.height = this.canvas.height;
    c.drawImage(this.canvas, 0, 0); c.drawImage(this.overlay.context.canvas, 0, 0, sheet.width, sheet.height);
  }
}
// How the body lies against the horizon: a level line, the body's own axis to its left and right, and an arrow along its nose.
function addLevel(scene, m, own) {
  const along = m.turned([1, 0, 0]), level = unit([-along[1], along[0], 0]), c = m.world(m.at(m.com)), r = 1.3 * m.reach, lie = m.turned([0, 1, 0]);
  scene.line(add(c, level, -1.4 * r), add(c, level, 1.4 * r), 1.6, own.ink);
  for (const k of [0, 1]) {
    const q = k ? -r : r, end = add(c, lie, q);
    scene.line(c, end, 3, own.sides[k]);
    scene.tri(scene.glass, c, add(c, level, q), end, faded(own.sides[k], 0.35));
  }
  scene.arrow(c, along.map(v => 1.2 * r * v), 2.5, own.ink);
}
function boxOfShots(all) {
  const low = [0, 1, 2].map(() => Infinity), high = [0, 1, 2].map(() => -Infinity);
  for (const shot of all) shot.corners.forEach((column, k) => { for (const v of column) { low[k] = Math.min(low[k], v); high[k] = Math.max(high[k], v); } });
  const size = Math.max(1e-3, ...[0, 1, 2].map(k => high[k] - low[k]));
  return { low, high, size, reach: 0.1 * size, step: round(size / 9), floor: low[2] };
}
