// The page: time, camera, keys and pointer.
(async () => {
  const data = JSON.parse($('data').textContent);
  for (const run of data.runs) $('verdicts').append(verdict(run));
  // What has been written is seen before anything is computed.
  await new Promise(painted => requestAnimationFrame(() => setTimeout(painted)));
  for (const run of data.runs) $('told').append(told(run, data.runs.length > 1));
  let runs;
  try { runs = read(await inflated($('bytes').textContent), data); }
  catch (error) { $('verdicts').append(make('p', { class: 'verdict bad' }, 'Nothing can be drawn: ' + error.message)); return; }
  $('bytes').textContent = '';
  const state = { t: 0, playing: false, speed: 1, dirty: true };
  const motions = runs.filter(run => run.motion && run.axis.values.length > 1).map(run => Object.assign(new Motion(run), { run }));
  const named = shared(motions);
  const shots = motions.length ? [] : runs.flatMap(run => run.shots.map(shot => ({ ...shot, run })));
  const plots = new Plots(runs, $('plots'), t => seek(t));
  const [low, high] = shots.length ? [0, shots.length - 1] : [plots.low, plots.high], span = high - low;
  window.wingbeat = { runs, state, frames: 0, seek: t => seek(t), low, high };
  if (!motions.length && !shots.length) { document.querySelector('main').classList.add('flat'); seek(low); return; }
  $('stage').hidden = false;
  const box = motions.length ? boxOf(motions) : boxOfShots(shots);
  const canvas = $('space'), marks = $('marks').getContext('2d', { willReadFrequently: true });
  let renderer, soft = false;
  try {
    if (location.hash.includes('2d')) throw new Error('asked for');
    const probe = document.createElement('canvas').getContext('webgl2'), info = probe && probe.getExtension('WEBGL_debug_renderer_info');
    soft = !!info && /swiftshader|llvmpipe|software/i.test(probe.getParameter(info.UNMASKED_RENDERER_WEBGL));
    if (probe && probe.getExtension('WEBGL_lose_context')) probe.getExtension('WEBGL_lose_context').loseContext();
    renderer = new Gl(canvas, soft);
  } catch (error) { renderer = new Flat(canvas); }
  window.wingbeat.renderer = renderer.kind;
  // A canvas that once drew with WebGL draws in no other way: the page begins again at its time with the other one.
  canvas.addEventListener('webglcontextlost', () => { location.hash = '2d&t=' + state.t.toFixed(3); location.reload(); });
  const camera = new Camera(), view = { mode: 'chase', azimuth: 0, elevation: 0.24, zoom: 1, shift: [0, 0, 0] };
  let quality = soft || renderer.kind === 'canvas' ? 0.7 : 1, look;
  function relook() {
    const style = getComputedStyle(document.documentElement), of = name => colour(style.getPropertyValue(name));
    look = { sky: of('--sky'), ground: of('--ground'), grid: of('--grid'), ink: of('--ink'), path: of('--ink'), body: [0.42, 0.45, 0.5, 1], thrust: of('--c3'), floor: shots.length ? undefined : box.floor,
      sides: [colour('#0072b2'), colour('#d55e00'), [0.55, 0.58, 0.62, 1]], sources: [0, 1, 2, 3, 4, 5, 6, 7].map(n => of('--c' + n)) };
    state.dirty = true;
  }
  relook();
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { relook(); frame(); });
  const still = matchMedia('(prefers-reduced-motion: reduce)');
  const tinted = (c, k) => k ? [...mixed(c.slice(0, 3), [1, 1, 1], 0.35 * Math.min(k, 2)), c[3]] : c;
  const looks = k => ({ ...look, sides: look.sides.map(c => tinted(c, k)), path: k ? look.sources[(k + 1) % 8] : look.path });
  function aim() {
    const m = motions[0], whole = ['whole', 'side', 'top'].includes(view.mode) || !m;
    const middle = [0, 1, 2].map(k => 0.5 * (box.low[k] + box.high[k]));
    const heading = m ? mixed([m.heading[m.i]], [m.heading[m.j]], m.s)[0] : 0, reach = box.reach;
    if (!whole) { camera.target = add(m.at(m.smooth), view.shift); camera.distance = 5 * reach * view.zoom; }
    camera.azimuth = (view.mode === 'chase' ? heading : 0) + view.azimuth;
    camera.elevation = Math.max(-1.5, Math.min(1.5, view.elevation));
    if (whole) { middle[2] = 0.5 * (box.floor + box.high[2]); camera.target = middle; fit(camera, canvas.clientWidth / canvas.clientHeight); camera.target = add(camera.target, view.shift); camera.distance *= view.zoom; }
  }
  // The least distance from which the whole way and its curtain are seen, and the target that centres them.
  function fit(cam, aspect) {
    const r = box.reach, corners = [];
    for (const run of motions) for (let k = 0; k <= 24; k++) { const i = Math.round(k * (run.n - 1) / 24), p = run.position.map(c => c[i]); corners.push([p[0], p[1], box.floor], ...[[r, 0, 0], [-r, 0, 0], [0, r, 0], [0, -r, 0], [0, 0, r]].map(d => add(p, d))); }
    for (const run of motions) for (const line of run.lines) for (const point of line.points) corners.push(point.map(c => c[0]), point.map(c => c[run.n - 1]));
    for (let k = 0; shots.length && k < 8; k++) corners.push([0, 1, 2].map(a => (k >> a & 1 ? box.high : box.low)[a]));
    cam.distance = 4 * box.size;
    for (let turn = 0; turn < 6; turn++) {
      const m = cam.matrix(aspect), seen = corners.map(p => transformed(m, p)).map(q => [q[0] / q[3], q[1] / q[3]]);
      const range = k => [Math.min(...seen.map(s => s[k])), Math.max(...seen.map(s => s[k]))], [x, y] = [range(0), range(1)];
      const half = cam.distance * Math.tan(cam.fov / 2);
      cam.target = add(add(cam.target, cam.right, 0.5 * (x[0] + x[1]) * half * Math.max(1, aspect)), cam.up, 0.5 * (y[0] + y[1]) * half / Math.min(1, aspect));
      cam.distance *= Math.max(x[1] - x[0], y[1] - y[0]) / 2 / 0.88;
    }
  }
  function choose(mode) {
    Object.assign(view, { mode, zoom: 1, shift: [0, 0, 0] }, { chase: { azimuth: -0.35, elevation: 0.25 }, follow: { azimuth: -0.7, elevation: 0.3 }, whole: { azimuth: 0.5, elevation: 0.42 }, side: { azimuth: Math.PI / 2, elevation: 0.06 }, top: { azimuth: 0, elevation: 1.5 } }[mode]);
    document.querySelectorAll('[data-camera]').forEach(b => b.setAttribute('aria-pressed', b.dataset.camera === mode));
    state.dirty = true;
  }
  function seek(t) {
    state.t = Math.max(low, Math.min(high, t));
    if (!shots.length) plots.mark(state.t);
    else plots.mark(shots[Math.round(state.t)].time);
    $('scrub').value = span ? 1000 * (state.t - low) / span : 0;
    const text = shots.length ? `${shots[Math.round(state.t)].name}` : `${state.t.toFixed(3)} s of ${high.toFixed(2)} s`;
    $('clock').textContent = text; $('scrub').setAttribute('aria-valuetext', text);
    state.dirty = true;
  }
  function play(on) {
    if (on && state.t >= high - 1e-9) seek(low);
    state.playing = on; state.last = undefined;
    $('play').textContent = on ? '❚❚' : '▶'; $('play').setAttribute('aria-label', on ? 'Pause' : 'Play');
    if (on) requestAnimationFrame(tick);
  }
  function tick(now) {
    if (!state.playing) return;
    if (state.last !== undefined) {
      const step = Math.min(0.25, (now - state.last) / 1000), rate = shots.length ? 1.2 * state.speed : state.speed;
      let t = state.t + step * rate;
      if (t > high) { if (shown.loop) t = low + (t - high) % (span || 1); else { seek(high); play(false); return; } }
      seek(t); adapt(now - state.last);
    }
    state.last = now;
    frame();
    requestAnimationFrame(tick);
  }
  // A slow machine gets fewer pixels.
  let slow = 0;
  function adapt(ms) { slow = ms > 34 ? slow + 1 : Math.max(0, slow - 0.5); if (slow > 12 && quality > 0.45) { quality *= 0.8; slow = 0; } }
  function frame() {
    if (!state.dirty || plots.printing) return;
    state.dirty = false; window.wingbeat.frames++;
    const w = canvas.clientWidth, h = canvas.clientHeight, ratio = (soft || renderer.kind === 'canvas' ? 1 : Math.min(2, devicePixelRatio || 1)) * quality, W = Math.max(2, Math.round(w * ratio)), H = Math.max(2, Math.round(h * ratio));
    if (!w || !h) { state.dirty = true; return; }
    if (canvas.width !== W || canvas.height !== H) { canvas.width = W; canvas.height = H; }
    const dense = Math.min(2, devicePixelRatio || 1);
    if (marks.canvas.width !== Math.round(w * dense)) { marks.canvas.width = Math.round(w * dense); marks.canvas.height = Math.round(h * dense); }
    if (marks.canvas.height !== Math.round(h * dense)) marks.canvas.height = Math.round(h * dense);
    marks.setTransform(dense, 0, 0, dense, 0, 0); said = [];
    if (shots.length) return drawShot(W, H, ratio);
    const flat = renderer.kind === 'canvas', ground = new Scene(), scene = new Scene();
    if (!box.table) addGround(ground, box, look); else ground.quad(...box.table, look.grid);
    motions.forEach((m, k) => {
      m.seek(state.t);
      const own = looks(k);
      if (m.free) addPath(scene, m, own, box.floor, view.mode === 'whole' || view.mode === 'side');
      if (m.path) for (let i = 0, step = Math.max(1, Math.floor(m.n / 200)); i + step < m.n; i += 2 * step) scene.line(m.path.map(c => c[i]), m.path.map(c => c[i + step]), 1.6, faded(look.thrust, 0.8));
      if (shown.wake && m.circulation) addWake(scene, m, flat);
      addRobot(scene, m, own, 1, box.floor, !flat);
      for (const line of m.lines) for (let i = 0; i + 1 < line.points.length; i++) scene.line(m.at(line.points[i]), m.at(line.points[i + 1]), line.weight, look.body);
      addForces(scene, m, own);
      const foot = [m.p[0], m.p[1], box.floor];
      if (!box.table) scene.line(m.p, foot, 1, faded(look.ink, 0.4));
      if (shown.level && m.free) {
        // How the body lies against the horizon: a level line, and the body's own axis to its left and right.
        const along = m.turned([1, 0, 0]), level = unit([-along[1], along[0], 0]), c = m.world(m.at(m.com)), r = 1.3 * m.reach, lie = m.turned([0, 1, 0]);
        scene.line(add(c, level, -r), add(c, level, r), 1.2, faded(look.ink, 0.75));
        scene.line(c, add(c, lie, r), 3, own.sides[0]); scene.line(c, add(c, lie, -r), 3, own.sides[1]);
      }
    });
    aim();
    renderer.pass([ground, scene], camera, [0, 0, W, H], look, ratio);
    labels(camera, [0, 0, w, h], view.mode !== 'chase' && view.mode !== 'follow');
    if (motions.some(m => m.free) && ['chase', 'follow'].includes(view.mode) && w > 330) {
      // The whole way in a corner, the robot enlarged.
      const iw = Math.round(0.34 * w), ih = Math.round(0.40 * h), pad = 8, small = new Scene(), inset = Object.assign(new Camera(), camera);
      motions.forEach((m, k) => { const own = looks(k); addPath(small, m, own, box.floor, true); addRobot(small, m, own, Math.max(1, Math.min(12, 0.11 * box.size / m.reach)), box.floor, false); });
      const middle = [0, 1, 2].map(k => 0.5 * (box.low[k] + box.high[k]));
      middle[2] = 0.5 * (box.floor + box.high[2]);
      Object.assign(inset, { target: middle, azimuth: 0.35, elevation: 0.36 }); fit(inset, iw / ih);
      renderer.pass([ground, small], inset, [Math.round(pad * ratio), Math.round(pad * ratio), Math.round(iw * ratio), Math.round(ih * ratio)], look, ratio);
      patch('', pad, h - pad - ih, iw, ih);
      if (iw > 240) labels(inset, [pad, h - pad - ih, iw, ih], true);
    }
    legend(w, h);
    put(w, h);
  }
  // Words and boxes over the picture are drawn again where one has moved.
  let said = [], put_before = '';
  const write = (text, x, y, align = 'left') => said.push([text, Math.round(x), Math.round(y), align]);
  const patch = (fill, x, y, w, h) => said.push([fill, x, y, w, h, 0]);
  function put(w, h) {
    const key = JSON.stringify(said) + w + h + look.sky;
    if (key === put_before) return;
    put_before = key; marks.clearRect(0, 0, w, h);
    for (const one of said) one.length === 6 ? box_or_frame(...one) : word(...one);
  }
  function box_or_frame(fill, x, y, w, h) { if (fill) { marks.fillStyle = fill; marks.fillRect(x, y, w, h); } else { marks.lineWidth = 1.5; marks.strokeStyle = getComputedStyle(document.documentElement).getPropertyValue('--quiet'); marks.strokeRect(x, y, w, h); } }
  const word = (text, x, y, align) => { const s = getComputedStyle(document.documentElement); marks.font = '12px system-ui, "DejaVu Sans", sans-serif'; marks.textAlign = align; marks.lineWidth = 3; marks.strokeStyle = s.getPropertyValue('--sky'); marks.strokeText(text, x, y); marks.fillStyle = s.getPropertyValue('--ink'); marks.fillText(text, x, y); };
  function labels(cam, [x, y, w, h], heights) {
    const m = cam.matrix(w / h), at = p => { const q = transformed(m, p); return q[3] > 0 ? [x + w * (0.5 + 0.5 * q[0] / q[3]), y + h * (0.5 - 0.5 * q[1] / q[3])] : null; };
    if (!heights || box.table || !motions.some(m => m.free)) return;
    const own = motions[0], last = own.n - 1;
    for (const [i, word] of [[0, 'start'], [last, 'end']]) {
      const p = [0, 1, 2].map(k => own.position[k][i]), q = at(p);
      if (q && q[0] > x + 24 && q[0] < x + w - 24 && q[1] > y + 16 && q[1] < y + h - 4) write(`${word}, ${digits(+(p[2] - box.floor).toFixed(2))} m above the grid`, Math.min(Math.max(q[0], x + 92), x + w - 92), q[1] - 10, 'center');
    }
    write(`grid ${digits(box.step)} m`, x + 8, y + h - 8);
  }
  function legend(w, h) {
    const m = motions[0];
    write('left wing', w - 88, 18); write('right wing', w - 88, 34);
    patch('#0072b2', w - 104, 9, 11, 10); patch('#d55e00', w - 104, 25, 11, 10);
    if (!(shown.wake && m.circulation)) return;
    const x = w - 226, y = h - 18;
    for (let i = 0; i < 160; i += 4) { const c = circulationColour((i - 78) / 60); patch(`rgba(${c.slice(0, 3).map(v => Math.round(255 * v))},${Math.max(0.1, c[3])})`, x + i, y, 4, 8); }
    const most = 0.7 * m.mostCirculation;
    write(m.circulation === 'circulation' ? 'circulation shed, m²/s' : w > 560 ? m.circulation + ', m²/s' : 'lag sum shed, m²/s', x + 210, y - 8, 'right');
    write(digits(+(-most).toPrecision(2)), x - 4, y + 8, 'right'); write(digits(+most.toPrecision(2)), x + 164, y + 8);
  }
  function boxOfShots(all) {
    const low = [0, 1, 2].map(() => Infinity), high = [0, 1, 2].map(() => -Infinity);
    for (const shot of all) shot.corners.forEach((column, k) => { for (const v of column) { low[k] = Math.min(low[k], v); high[k] = Math.max(high[k], v); } });
    const size = Math.max(1e-3, ...[0, 1, 2].map(k => high[k] - low[k]));
    return { low, high, size, reach: 0.1 * size, step: round(size / 9), floor: low[2] };
  }
  function drawShot(W, H, ratio) {
    const shot = shots[Math.round(state.t)], scene = new Scene(), most = shot.circulation.slice(shot.wings).reduce((m, v) => Math.max(m, Math.abs(v)), 1e-9);
    const corner = i => shot.corners.map(c => c[i]);
    shot.circulation.forEach((value, n) => {
      const [a, b, c, d] = [0, 1, 2, 3].map(k => corner(4 * n + k));
      if (n < shot.wings) { scene.quad(a, b, c, d, look.sides[0.25 * (a[1] + b[1] + c[1] + d[1]) >= 0 ? 0 : 1]); return; }
      if (shown.wake) scene.veil(a, b, c, d, circulationColour(value / (0.7 * most)));
    });
    aim();
    renderer.pass([scene], camera, [0, 0, W, H], look, ratio);
    write(`${shot.name}, t = ${digits(shot.time)} s; circulation within ±${digits(+most.toPrecision(2))} m²/s`, 10, 20);
    put(canvas.clientWidth, canvas.clientHeight);
  }
  // Controls.
  const toggle = (name, text, value, act) => { const input = make('input', { type: 'checkbox' }); input.checked = value; input.addEventListener('change', () => { act(input.checked); state.dirty = true; frame(); }); const label = make('label', {}, input, text); label.dataset.name = name; return label; };
  const press = name => { const input = document.querySelector(`[data-name="${name}"] input`); if (input) input.click(); };
  if (shots.length || motions.some(m => m.circulation)) $('shows').append(toggle('wake', 'wake', true, on => shown.wake = on));
  if (motions.some(m => m.circulation)) { const s = make('select', { 'aria-label': 'Length of the wake' }); for (const v of [0.3, 1, 3]) s.append(make('option', { value: v, ...(v === 0.3 ? { selected: '' } : {}) }, `${v} s of it`)); s.addEventListener('change', () => { shown.wakeTime = +s.value; state.dirty = true; frame(); }); $('shows').append(s); }
  if (motions.some(m => m.free)) $('shows').append(toggle('level', 'level line', true, on => shown.level = on));
  if (motions.some(m => m.surfaces.some(s => s.strips.some(p => p.force)))) $('shows').append(toggle('strips', 'force of each strip', false, on => shown.strips = on));
  $('shows').append(toggle('loop', 'repeat', true, on => shown.loop = on));
  named.forEach((source, n) => { const label = toggle('source-' + n, '', false, on => shown.sources[source] = on), swatch = make('span', { class: 'swatch', 'aria-hidden': 'true' }); swatch.style.borderTopColor = `var(--c${n % 8})`; label.append(swatch, source); $('sources').append(label); });
  $('forces').hidden = !named.length;
  $('play').addEventListener('click', () => play(!state.playing));
  $('scrub').addEventListener('input', () => { seek(low + span * $('scrub').value / 1000); frame(); });
  $('speed').addEventListener('change', () => state.speed = +$('speed').value);
  $('fit').addEventListener('click', () => { choose(view.mode); frame(); });
  document.querySelectorAll('[data-camera]').forEach(b => b.addEventListener('click', () => { choose(b.dataset.camera); frame(); }));
  const steps = motions.length ? span / (motions[0].n - 1) : 1;
  addEventListener('keydown', event => {
    if (event.ctrlKey || event.altKey || event.metaKey || /SELECT|TEXTAREA/.test(event.target.tagName)) return;
    const range = event.target.id === 'scrub', key = event.key, cameras = ['chase', 'follow', 'whole', 'side', 'top'];
    if (event.target.tagName === 'INPUT' && !range && key === ' ') return;
    if (event.target.tagName === 'BUTTON' && (key === ' ' || key === 'Enter')) return;
    if (key === ' ') play(!state.playing);
    else if (key === 'ArrowRight' || key === 'ArrowLeft') { play(false); seek(state.t + (key === 'ArrowRight' ? 1 : -1) * steps * (event.shiftKey ? 10 : 1)); }
    else if (key === 'Home') seek(low); else if (key === 'End') seek(high);
    else if (key === '+' || key === '-') { const s = $('speed'); s.selectedIndex = Math.max(0, Math.min(s.options.length - 1, s.selectedIndex + (key === '+' ? 1 : -1))); state.speed = +s.value; }
    else if (key >= '1' && key <= '5') choose(cameras[+key - 1]);
    else if (key === 'f' || key === 'F') choose(view.mode);
    else if ('wls'.includes(key.toLowerCase())) press({ w: 'wake', l: 'level', s: 'strips' }[key.toLowerCase()]);
    else return;
    event.preventDefault(); frame();
  });
  const fingers = new Map();
  canvas.addEventListener('pointerdown', event => { canvas.setPointerCapture(event.pointerId); fingers.set(event.pointerId, [event.clientX, event.clientY]); });
  for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, event => fingers.delete(event.pointerId));
  canvas.addEventListener('contextmenu', event => event.preventDefault());
  canvas.addEventListener('pointermove', event => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const dx = event.clientX - before[0], dy = event.clientY - before[1];
    if (fingers.size === 2) {
      const other = [...fingers].find(([id]) => id !== event.pointerId)[1], spread = p => Math.hypot(p[0] - other[0], p[1] - other[1]);
      view.zoom *= Math.max(0.5, Math.min(2, spread(before) / Math.max(1, spread([event.clientX, event.clientY]))));
    } else if (event.shiftKey || event.buttons === 2) {
      const k = camera.distance * 0.62 / canvas.clientHeight;
      view.shift = add(add(view.shift, camera.right, -dx * k), camera.up, dy * k);
    } else { view.azimuth -= 0.008 * dx; view.elevation = Math.max(-1.5, Math.min(1.5, view.elevation + 0.008 * dy)); }
    view.zoom = Math.max(0.05, Math.min(20, view.zoom));
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
    state.dirty = true; frame();
  });
  canvas.addEventListener('wheel', event => { event.preventDefault(); view.zoom = Math.max(0.05, Math.min(20, view.zoom * Math.exp(0.0012 * event.deltaY))); state.dirty = true; frame(); }, { passive: false });
  new ResizeObserver(() => { state.dirty = true; frame(); }).observe(canvas);
  // A canvas that was drawn just now is not yet on paper; a copy of it is.
  function copy() {
    const sheet = $('sheet'), c = sheet.getContext('2d');
    sheet.width = canvas.width; sheet.height = canvas.height;
    c.drawImage(canvas, 0, 0); c.drawImage(marks.canvas, 0, 0, sheet.width, sheet.height);
  }
  // On paper: light colours, the picture as it stands, plots as wide as two columns have room.
  addEventListener('beforeprint', () => { play(false); document.documentElement.classList.add('printing'); relook(); frame(); copy(); plots.printing = true; plots.layout(336); });
  addEventListener('afterprint', () => { plots.printing = false; document.documentElement.classList.remove('printing'); relook(); plots.layout(); frame(); });
  Object.assign(window.wingbeat, { view, camera, play, frame: () => { state.dirty = true; frame(); } });
  choose(motions.some(m => m.free) ? 'chase' : 'follow');
  if (!motions.some(m => m.free)) { document.querySelector('[data-camera="chase"]').hidden = true; if (box.table || shots.length) { choose('whole'); if (shots.length) view.azimuth = -1; } }
  const start = /t=([\d.]+)/.exec(location.hash);
  seek(start ? +start[1] : low); frame();
  if (!still.matches && !start && !location.hash.includes('still')) play(true);
  window.wingbeat.ready = true;
})();
