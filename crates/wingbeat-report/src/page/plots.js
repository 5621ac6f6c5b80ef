// The plots: one panel for all runs that have it, a line where the time is, values beside the names.
const SVG = 'http://www.w3.org/2000/svg';
const svg = (name, attributes, text) => { const e = document.createElementNS(SVG, name); for (const [k, v] of Object.entries(attributes)) e.setAttribute(k, v); if (text !== undefined) e.textContent = text; return e; };
// Numbers of the colours of several runs: none is that of a wing.
const ofRun = k => [2, 3, 4, 6, 7, 5][k % 6];
const DASHES = ['', '7 4', '2 3', '9 3 2 3'];
function paint([kind, n], run, which) {
  // Of several runs each has a colour, and each of its curves another line.
  if (run !== undefined && kind !== 'reference') return { stroke: `var(--c${ofRun(run)})`, width: 1.5, dash: DASHES[which % 4], opacity: kind === 'pale' ? 0.5 : 1 };
  // The same on both sides is seen as both.
  if (kind === 'side') return { stroke: ['var(--left)', 'var(--right)'][n], width: [2.8, 1.3][n] };
  if (kind === 'own') return { stroke: `var(--c${n % 8})`, width: 1.6 };
  if (kind === 'pale') return { stroke: ['var(--left)', 'var(--right)', 'var(--quiet)'][n], width: 3.4, opacity: 0.35 };
  if (kind === 'reference') return { stroke: 'var(--quiet)', width: 1.3, dash: '5 4' };
  return { stroke: 'var(--ink)', width: 2 };
}
function ticks(low, high, most) {
  const step = round((high - low) / most) || 1, out = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step && out.length < 20; k++) out.push(+(k * step).toPrecision(12));
  return out.length < 2 && most < 64 ? ticks(low, high, 2 * most) : out;
}
// A value with the digits that the page holds of it.
function rounded(v, { step }) { const q = 10 ** Math.ceil(Math.log10(step)); return Number.isFinite(v) && step > 0 ? Math.round(v / q) * q || 0 : v; }
class Plots {
  constructor(runs, root, seek) {
    this.runs = runs; this.root = root; this.seek = seek; this.panels = [];
    const axes = runs.map(run => run.axis);
    this.low = Math.min(...axes.filter(a => a.values.length).map(a => a.values[0])); this.high = Math.max(...axes.filter(a => a.values.length).map(a => a.values[a.values.length - 1]));
    if (!(this.low <= this.high)) this.low = this.high = 0;
    runs.forEach((run, r) => run.panels.forEach(panel => {
      let found = this.panels.find(p => p.title === panel.title && p.unit === panel.unit);
      if (!found) this.panels.push(found = { title: panel.title, unit: panel.unit, limits: panel.limits, curves: [] });
      panel.curves.forEach(curve => found.curves.push({ ...curve, run: r }));
    }));
    this.watch = new IntersectionObserver(entries => {
      for (const entry of entries) { const panel = this.panels.find(p => p.box === entry.target); if (panel) panel.seen = entry.isIntersecting; }
      if (this.now !== undefined) this.mark(this.now, true);
    });
    for (const panel of this.panels) this.build(panel);
    this.layout();
    this.sized = new ResizeObserver(() => this.printing || this.layout());
    this.sized.observe(root);
  }
  // Makes room for others.
  away() { this.watch.disconnect(); this.sized.disconnect(); clearTimeout(this.later); this.root.replaceChildren(); }
  build(panel) {
    const several = this.runs.length > 1, keys = make('div', { class: 'keys' });
    const labels = [...new Set(panel.curves.filter(c => c.role[0] !== 'reference').map(c => c.label))];
    panel.outputs = panel.curves.map(curve => {
      const p = curve.paint = several ? paint(curve.role, curve.run, labels.indexOf(curve.label)) : paint(curve.role), out = make('output'), swatch = make('span', { class: 'swatch', 'aria-hidden': 'true' });
      swatch.style.borderTopColor = p.stroke; swatch.style.borderTopWidth = Math.min(3, p.width + 0.6) + 'px';
      swatch.style.borderTopStyle = p.dash ? p.dash === '2 3' ? 'dotted' : 'dashed' : 'solid'; swatch.style.opacity = p.opacity || 1;
      keys.append(make('span', {}, swatch, ' ', (several ? this.runs[curve.run].name + (curve.label ? ': ' : '') : '') + curve.label, ' ', out));
      return out;
    });
    panel.svg = svg('svg', { role: 'img', 'aria-label': `${panel.title}${panel.unit ? ' in ' + panel.unit : ''} over ${this.runs[0].axis.label}` });
    const at = event => {
      const box = panel.svg.getBoundingClientRect(), share = (event.clientX - box.left - this.left) / (box.width - this.left - 6);
      this.seek(this.low + Math.max(0, Math.min(1, share)) * (this.high - this.low));
    };
    panel.svg.addEventListener('pointerdown', event => { panel.held = true; at(event); });
    panel.svg.addEventListener('pointermove', event => panel.held && event.buttons && at(event));
    for (const end of ['pointerup', 'pointerleave', 'pointercancel']) panel.svg.addEventListener(end, () => panel.held = false);
    const unit = panel.unit.replace('deg', '°').replace(/2/g, '²'), title = make('h3', {}, panel.title + (unit ? ` [${unit}]` : ''));
    // The line where the time is lies over the plot, which so is drawn once.
    panel.cursor = make('div', { class: 'cursor', 'aria-hidden': 'true' });
    panel.box = make('div', { class: 'panel' }, title, make('div', { class: 'plot' }, panel.svg, panel.cursor), keys);
    panel.seen = true;
    this.watch.observe(panel.box);
    this.root.append(panel.box);
    panel.range = this.range(panel);
  }
  range(panel) {
    let low = Infinity, high = -Infinity;
    for (const curve of panel.curves) for (const v of curve.values) if (Number.isFinite(v)) { if (v < low) low = v; if (v > high) high = v; }
    if (!(low <= high)) [low, high] = [0, 1];
    // Limits are drawn where the curve comes near.
    if (panel.limits) for (const limit of panel.limits) if (limit > low - 0.6 * (high - low) && limit < high + 0.6 * (high - low)) { low = Math.min(low, limit); high = Math.max(high, limit); }
    // Less than this is rounding.
    if (high - low < 1e-9 * Math.max(1, Math.abs(high))) { const middle = 0.5 * (low + high), room = Math.abs(middle) < 1e-9 ? 1 : 0.5 * Math.abs(middle); low = middle - room; high = middle + room; }
    const margin = 0.06 * (high - low) || 0.05 * Math.abs(high) || 1;
    return [low - margin, high + margin];
  }
  layout(asked) {
    const width = asked || (this.panels.length ? this.panels[0].svg.getBoundingClientRect().width : 0);
    if (!width || width === this.width) return;
    this.width = width;
    this.left = 10 + 6.2 * Math.max(6, ...this.panels.flatMap(panel => ticks(...panel.range, 4).map(y => digits(y).length)));
    for (const panel of this.panels) this.drawn(panel, width, 118);
    this.mark(this.now === undefined ? this.low : this.now, true);
  }
  drawn(panel, w, h) {
    const s = panel.svg, [low, high] = panel.range, left = this.left, right = w - 6, bottom = h - 18;
    const X = x => left + (right - left) * (x - this.low) / (this.high - this.low || 1), Y = y => bottom - (bottom - 9) * (y - low) / (high - low);
    s.replaceChildren(); s.setAttribute('viewBox', `0 0 ${w} ${h}`);
    for (const y of ticks(low, high, 4)) { s.append(svg('line', { x1: left, x2: right, y1: Y(y), y2: Y(y), stroke: 'var(--line)' }), svg('text', { x: left - 4, y: Y(y) + 4, 'text-anchor': 'end' }, digits(y))); }
    const axis = this.runs[0].axis;
    const word = axis.unit || axis.label, free = right - 3 - 6 * word.length;
    ticks(this.low, this.high, Math.max(2, w / 90)).forEach(x => {
      const half = 3.2 * digits(x).length;
      s.append(svg('line', { x1: X(x), x2: X(x), y1: bottom, y2: bottom + 4, stroke: 'var(--quiet)' }));
      if (X(x) + half < free) s.append(svg('text', { x: X(x), y: h - 4, 'text-anchor': 'middle' }, digits(x)));
    });
    s.append(svg('text', { x: right, y: h - 4, 'text-anchor': 'end' }, word));
    s.append(svg('line', { x1: left, x2: right, y1: bottom, y2: bottom, stroke: 'var(--quiet)' }));
    if (panel.limits) for (const limit of panel.limits) if (limit >= low && limit <= high) { s.append(svg('line', { x1: left, x2: right, y1: Y(limit), y2: Y(limit), stroke: 'var(--bad)', 'stroke-dasharray': '3 3' }), svg('text', { x: right - 2, y: Y(limit) + (limit > 0 ? 12 : -3), 'text-anchor': 'end' }, 'limit ' + digits(limit))); }
    for (const curve of panel.curves) {
      const { values: t, joined } = this.runs[curve.run].axis, p = curve.paint;
      if (!joined) { for (let i = 0; i < t.length; i++) if (Number.isFinite(curve.values[i])) s.append(svg('circle', { cx: X(t[i]).toFixed(1), cy: Y(curve.values[i]).toFixed(1), r: 2, fill: p.stroke })); continue; }
      const path = this.way(t, curve.values, X, Y, right - left, panel.unit === 'deg' ? 90 : Infinity);
      s.append(svg('path', { d: path, fill: 'none', stroke: p.stroke, 'stroke-width': p.width, 'stroke-dasharray': p.dash || '', opacity: p.opacity || 1, 'stroke-linejoin': 'round' }));
    }
    panel.X = X;
  }
  // Of many points in one column of pixels the least and the most; an angle that turns over between two frames is not joined.
  way(t, values, X, Y, pixels, jump) {
    const n = t.length, bin = Math.max(1, Math.floor(n / pixels / 1.2));
    let d = '', pen = 'M';
    const to = i => { d += `${pen}${X(t[i]).toFixed(1)} ${Y(values[i]).toFixed(1)}`; pen = 'L'; };
    for (let i = 0, k; i < n; i = k) {
      let least = i, most = i;
      const end = Math.min(n, i + bin);
      for (k = i; k < end && Number.isFinite(values[k]); k++) { if (values[k] < values[least]) least = k; if (values[k] > values[most]) most = k; }
      if (k > i) {
        if (i && Math.abs(values[i] - values[i - 1]) > jump) pen = 'M';
        if (least === most) to(least); else { to(Math.min(least, most)); to(Math.max(least, most)); }
      }
      if (k < end) { pen = 'M'; k++; }
    }
    return d;
  }
  // Values are written ten times a second, and only where they are seen.
  mark(t, all) {
    this.now = t;
    const now = performance.now(), words = all || !(now - this.written < 100);
    if (words) this.written = now; else { clearTimeout(this.later); this.later = setTimeout(() => this.mark(this.now, true), 150); }
    const rows = this.runs.map(run => { const [i, s] = place(run.axis.values, t); return s > 0.5 ? i + 1 : i; });
    for (const panel of this.panels) {
      if (!panel.X || !(panel.seen || all)) continue;
      panel.cursor.style.transform = `translateX(${panel.X(t).toFixed(1)}px)`;
      // On paper a plot stands in the middle of its box.
      panel.cursor.style.left = this.printing ? `calc(50% - ${this.width / 2}px)` : '';
      if (!words) continue;
      panel.curves.forEach((curve, k) => { panel.outputs[k].textContent = digits(rounded(curve.values[rows[curve.run]], curve.values)); });
    }
  }
}
