// Words and boxes over the picture, drawn again where one has moved.
class Overlay {
  constructor(canvas) { this.context = canvas.getContext('2d', { willReadFrequently: true }); this.said = []; this.before = ''; }
  relook(style) { this.colours = Object.fromEntries(['sky', 'ink', 'quiet'].map(name => [name, style.getPropertyValue('--' + name)])); }
  begin(w, h) {
    const { canvas } = this.context, dense = Math.min(2, devicePixelRatio || 1), W = Math.round(w * dense), H = Math.round(h * dense);
    if (canvas.width !== W) canvas.width = W;
    if (canvas.height !== H) canvas.height = H;
    this.context.setTransform(dense, 0, 0, dense, 0, 0); this.said = [];
  }
  write(text, x, y, align = 'left') { this.said.push([text, Math.round(x), Math.round(y), align]); }
  patch(fill, x, y, w, h) { this.said.push([fill, x, y, w, h, 0]); }
  put(w, h) {
    const key = JSON.stringify(this.said) + w + h + this.colours.sky + this.context.canvas.width;
    if (key === this.before) return;
    this.before = key; this.context.clearRect(0, 0, w, h);
    for (const one of this.said) one.length === 6 ? this.area(...one) : this.word(...one);
  }
  area(fill, x, y, w, h) {
    const c = this.context;
    if (fill) { c.fillStyle = fill; c.fillRect(x, y, w, h); } else { c.lineWidth = 1.5; c.strokeStyle = this.colours.quiet; c.strokeRect(x, y, w, h); }
  }
  word(text, x, y, align) {
    const c = this.context;
    c.font = '12px system-ui, "DejaVu Sans", sans-serif'; c.textAlign = align; c.lineWidth = 3; c.strokeStyle = this.colours.sky;
    c.strokeText(text, x, y); c.fillStyle = this.colours.ink; c.fillText(text, x, y);
  }
  legend(w, h, motions, level, box) {
    const m = motions[0], camber = Math.max(...motions.map(m => m.camber)), has = side => motions.some(m => m.surfaces.some(s => s.side.some((of, k) => of === side && s.covered[k])));
    let y0 = this.wings(w, [has(0), has(1)]);
    const say = text => { this.write(text, w - 12, y0 + 4, 'right'); y0 += 16; }, size = shown.camber > 1 ? ', drawn × ' + shown.camber : '';
    if (level && w > 420) say('arrow: nose; thin line: level');
    if (box.ground !== undefined) say(`${box.below ? 'brown: ground' : box.ceiling !== undefined ? 'brown: ceiling' : 'not drawn: ground'} at z = ${digits(box.ground)} m`);
    if (m.path) say('dashed: path asked for');
    if (camber > 0) say('camber up to ' + digits(+(100 * camber).toPrecision(2)) + ' % of the chord' + size);
    if (!m.free && norm(m.wind)) say('arrow: wind, ' + digits(+norm(m.wind).toPrecision(3)) + ' m/s');
    if (shown.wake && m.circulation) this.scale(w, h, 0.7 * m.mostCirculation, m.circulation === 'circulation' ? 'circulation shed, m²/s' : w > 560 ? m.circulation + ', m²/s' : 'lag sum shed, m²/s');
  }
  // The colours of the wings that there are; answers where there is room below.
  wings(w, has) {
    let y = 18;
    ['left wing', 'right wing'].forEach((name, side) => { if (has[side]) { this.write(name, w - 88, y); this.patch(['#0072b2', '#d55e00'][side], w - 104, y - 9, 11, 10); y += 16; } });
    return y;
  }
  // Of panels at those places to the left.
  sides(w, left) { this.wings(w, [left.some(y => y > 0), left.some(y => y < 0)]); }
  scale(w, h, most, text) {
    const n = w > 420 ? 160 : 80, x = w - n - 66, y = h - 18;
    for (let i = 0; i < n; i += 4) { const c = circulationColour((i + 2 - 0.5 * n) / (0.375 * n)); this.patch(`rgba(${c.slice(0, 3).map(v => Math.round(255 * v))},${Math.max(0.1, c[3])})`, x + i, y, 4, 8); }
    this.write(text, x + n + 50, y - 8, 'right');
    this.write(digits(+(-most).toPrecision(2)), x - 4, y + 8, 'right'); this.write(digits(+most.toPrecision(2)), x + n + 4, y + 8);
  }
}
