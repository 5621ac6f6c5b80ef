// Buttons, keys, mouse and fingers.
const CAMERAS = ['chase', 'follow', 'whole', 'side', 'top'];
class Controls {
  constructor(stage) {
    this.stage = stage; this.fingers = new Map();
    this.buttons(); this.keys(); this.pointer(); this.paper();
  }
  draw() { this.stage.state.dirty = true; this.stage.frame(); }
  toggle(name, text, value, act) {
    const input = make('input', { type: 'checkbox' }), label = make('label', {}, input, text);
    input.checked = value; label.dataset.name = name;
    input.addEventListener('change', () => { act(input.checked); this.draw(); });
    return label;
  }
  // What these runs have to show; what was chosen before stays chosen.
  offer(motions, shots) {
    const strips = motions.some(m => m.surfaces.some(s => s.strips.some(p => p.force))), circulation = motions.some(m => m.circulation), { named, free } = this.stage;
    const camber = motions.some(m => m.camber > 0), key = JSON.stringify([circulation, shots.length > 0, free, strips, camber, named]);
    if (key === this.offered) return;
    this.offered = key;
    const rows = [];
    if (shots.length || circulation) rows.push(this.toggle('wake', 'wake', shown.wake, on => shown.wake = on));
    if (circulation) rows.push(this.lengths());
    if (free) rows.push(this.toggle('level', 'level line', shown.level, on => shown.level = on));
    if (strips) rows.push(this.toggle('strips', 'force of each strip, all sources', shown.strips, on => shown.strips = on));
    if (camber) rows.push(this.toggle('camber', 'camber × 5', shown.camber > 1, on => shown.camber = on ? 5 : 1));
    rows.push(this.toggle('loop', 'repeat', shown.loop, on => shown.loop = on));
    $('shows').replaceChildren(...rows);
    $('sources').replaceChildren(...named.map((source, n) => this.source(source, n)));
    $('forces').hidden = !named.length;
    document.querySelector('[data-camera="chase"]').hidden = !free;
    document.querySelector('[data-camera="follow"]').hidden = !motions.length;
  }
  lengths() {
    const select = make('select', { 'aria-label': 'Length of the wake' });
    for (const v of [0.3, 1, 3]) select.append(make('option', { value: v, selected: v === shown.wakeTime ? '' : undefined }, `${v} s of it`));
    select.addEventListener('change', () => { shown.wakeTime = +select.value; this.draw(); });
    return select;
  }
  source(name, n) {
    const label = this.toggle('source-' + n, '', !!shown.sources[name], on => shown.sources[name] = on), swatch = make('span', { class: 'swatch', 'aria-hidden': 'true' });
    swatch.style.borderTopColor = `var(--c${n % 8})`; label.append(swatch, name);
    return label;
  }
  buttons() {
    const { stage } = this;
    $('play').addEventListener('click', () => stage.play(!stage.state.playing));
    $('scrub').addEventListener('input', () => { stage.seek(stage.low + stage.span * $('scrub').value / 1000); stage.frame(); });
    $('speed').addEventListener('change', () => stage.state.speed = +$('speed').value);
    $('fit').addEventListener('click', () => { stage.choose(stage.view.mode); stage.frame(); });
    document.querySelectorAll('[data-camera]').forEach(b => b.addEventListener('click', () => { stage.choose(b.dataset.camera); stage.frame(); }));
  }
  keys() {
    addEventListener('keydown', event => {
      if (event.ctrlKey || event.altKey || event.metaKey || $('stage').hidden || /SELECT|TEXTAREA/.test(event.target.tagName)) return;
      const { key, target } = event;
      if (target.tagName === 'INPUT' && target.id !== 'scrub' && key === ' ') return;
      if (/BUTTON|SUMMARY/.test(target.tagName) && (key === ' ' || key === 'Enter')) return;
      if (!this.key(key, event.shiftKey)) return;
      event.preventDefault(); this.stage.frame();
    });
  }
  // Does what a key is for; answers whether it is for something.
  key(key, shift) {
    const { stage } = this, { state } = stage, letter = key.toLowerCase();
    if (key === ' ') stage.play(!state.playing);
    else if (key === 'ArrowRight' || key === 'ArrowLeft') {
      const step = stage.motions.length ? stage.span / (stage.motions[0].n - 1) : 1;
      stage.play(false); stage.seek(state.t + (key === 'ArrowRight' ? 1 : -1) * step * (shift ? 10 : 1));
    } else if (key === 'Home') stage.seek(stage.low);
    else if (key === 'End') stage.seek(stage.high);
    else if (key === '+' || key === '-') { const s = $('speed'); s.selectedIndex = limited(s.selectedIndex + (key === '+' ? 1 : -1), 0, s.options.length - 1); state.speed = +s.value; }
    else if (key >= '1' && key <= '5') stage.choose(CAMERAS[+key - 1]);
    else if (letter === 'f') stage.choose(stage.view.mode);
    else if ('wlsc'.includes(letter)) { const input = document.querySelector(`[data-name="${{ w: 'wake', l: 'level', s: 'strips', c: 'camber' }[letter]}"] input`); if (input) input.click(); }
    else return false;
    return true;
  }
  pointer() {
    const { canvas, view } = this.stage;
    canvas.addEventListener('pointerdown', event => { canvas.setPointerCapture(event.pointerId); this.fingers.set(event.pointerId, [event.clientX, event.clientY]); });
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, event => this.fingers.delete(event.pointerId));
    canvas.addEventListener('contextmenu', event => event.preventDefault());
    canvas.addEventListener('pointermove', event => this.moved(event));
    canvas.addEventListener('wheel', event => { event.preventDefault(); view.zoom = limited(view.zoom * Math.exp(0.0012 * event.deltaY), 0.05, 20); this.draw(); }, { passive: false });
  }
  moved(event) {
    const { fingers } = this, { view, camera, canvas } = this.stage, before = fingers.get(event.pointerId), now = [event.clientX, event.clientY];
    if (!before) return;
    const dx = now[0] - before[0], dy = now[1] - before[1];
    if (fingers.size === 2) {
      const other = [...fingers].find(([id]) => id !== event.pointerId)[1], spread = p => Math.hypot(p[0] - other[0], p[1] - other[1]);
      view.zoom = limited(view.zoom * limited(spread(before) / Math.max(1, spread(now)), 0.5, 2), 0.05, 20);
    } else if (event.shiftKey || event.buttons === 2) {
      const k = camera.distance * 0.62 / canvas.clientHeight;
      view.shift = add(add(view.shift, camera.right, -dx * k), camera.up, dy * k);
    } else { view.azimuth -= 0.008 * dx; view.elevation = limited(view.elevation + 0.008 * dy, -1.5, 1.5); }
    fingers.set(event.pointerId, now);
    this.draw();
  }
  // On paper: light colours, the picture as it stands, plots as wide as two columns have room.
  paper() {
    const { stage } = this, printing = on => document.documentElement.classList.toggle('printing', on);
    addEventListener('beforeprint', () => { printing(true); stage.paper = true; stage.play(false); stage.relook(); stage.sharpen(); stage.copy(); stage.plots.printing = true; stage.plots.layout(336); });
    addEventListener('afterprint', () => { printing(false); stage.paper = stage.plots.printing = false; stage.relook(); stage.plots.layout(); stage.frame(); });
  }
}
