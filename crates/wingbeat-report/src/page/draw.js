// Camera, and two ways to draw a scene: WebGL 2, and a canvas that sorts by depth.
class Camera {
  constructor() { this.azimuth = 0; this.elevation = 0.3; this.distance = 1; this.target = [0, 0, 0]; this.fov = 0.62; }
  matrix(aspect) {
    const ce = Math.cos(this.elevation), se = Math.sin(this.elevation), ca = Math.cos(this.azimuth), sa = Math.sin(this.azimuth);
    const forward = [ca * ce, sa * ce, -se], right = [sa, -ca, 0], up = cross(right, forward);
    this.eye = add(this.target, forward, -this.distance);
    Object.assign(this, { forward, right, up });
    // The field of view is that of the shorter side.
    const f = 1 / Math.tan(this.fov / 2), near = Math.max(1e-3, 0.02 * this.distance), far = 400 * this.distance + 100;
    const a = (far + near) / (far - near), b = -2 * far * near / (far - near), e = this.eye;
    const row = (v, k) => [v[0] * k, v[1] * k, v[2] * k, -dot(v, e) * k];
    const x = row(right, f / Math.max(1, aspect)), y = row(up, f * Math.min(1, aspect)), z = row(forward, a), w = row(forward, 1);
    z[3] += b;
    return [x, y, z, w];
  }
}
const transformed = (m, p) => m.map(r => r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3]);
class Gl {
  constructor(canvas, soft) {
    const gl = this.gl = canvas.getContext('webgl2', { antialias: !soft, preserveDrawingBuffer: true, alpha: false });
    if (!gl) throw new Error('no WebGL 2');
    const program = (vertex, attributes) => {
      const p = gl.createProgram();
      for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, 'in vec4 k;out vec4 o;void main(){o=k;}']]) {
        const s = gl.createShader(kind);
        gl.shaderSource(s, '#version 300 es\nprecision highp float;\n' + source); gl.compileShader(s); gl.attachShader(p, s);
      }
      attributes.forEach((name, i) => gl.bindAttribLocation(p, i, name));
      gl.linkProgram(p);
      if (!gl.getProgramParameter(p, gl.LINK_STATUS)) throw new Error('WebGL 2 programs do not link');
      return p;
    };
    this.triangles = program('in vec3 p;in vec4 c;uniform mat4 m;out vec4 k;void main(){k=c;gl_Position=m*vec4(p,1.);}', ['p', 'c']);
    this.strokes = program(`in vec2 e;in vec3 a;in vec3 b;in float w;in vec4 c;uniform mat4 m;uniform vec2 size;out vec4 k;
      void main(){k=c;vec4 A=m*vec4(a,1.),B=m*vec4(b,1.);float n=1e-3;
      if(A.w<n&&B.w<n){gl_Position=vec4(0.,0.,-2.,1.);return;}
      if(A.w<n)A=mix(A,B,(n-A.w)/(B.w-A.w));if(B.w<n)B=mix(B,A,(n-B.w)/(A.w-B.w));
      vec2 d=(B.xy/B.w-A.xy/A.w)*size;float l=length(d);d=l>1e-6?d/l:vec2(1.,0.);vec4 P=e.x<.5?A:B;
      P.xy+=vec2(-d.y,d.x)*e.y*w/size*P.w;P.z-=2e-4*P.w;gl_Position=P;}`, ['e', 'a', 'b', 'w', 'c']);
    this.corner = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, this.corner);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array([0, -1, 0, 1, 1, -1, 1, 1]), gl.STATIC_DRAW);
    this.buffer = gl.createBuffer();
    gl.enable(gl.BLEND); gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA); gl.enable(gl.SCISSOR_TEST);
    this.kind = 'WebGL 2';
  }
  pass(scenes, camera, [x, y, w, h], look, ratio) {
    const gl = this.gl, rows = camera.matrix(w / h), m = new Float32Array(16);
    rows.forEach((row, r) => row.forEach((v, c) => m[4 * c + r] = v));
    gl.viewport(x, y, w, h); gl.scissor(x, y, w, h);
    gl.clearColor(look.sky[0], look.sky[1], look.sky[2], 1); gl.depthMask(true); gl.disable(gl.DEPTH_TEST);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const ground = new Scene(), far = 200 * camera.distance + 50, [cx, cy] = camera.target;
    const g = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([i, j]) => [cx + i * far, cy + j * far, look.floor]);
    if (look.floor !== undefined) ground.veil(...g, look.ground);
    this.draw(ground.glass, m);
    for (const s of scenes) this.draw(s.under, m);
    gl.enable(gl.DEPTH_TEST);
    for (const s of scenes) this.draw(s.solid, m);
    for (const s of scenes) this.stroke(s.lines, m, [w / 2, h / 2], ratio);
    gl.depthMask(false);
    for (const s of scenes) this.draw(s.glass, m);
    gl.depthMask(true);
  }
  draw(list, m) {
    if (!list.length) return;
    const gl = this.gl;
    gl.useProgram(this.triangles);
    gl.uniformMatrix4fv(gl.getUniformLocation(this.triangles, 'm'), false, m);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(list), gl.STREAM_DRAW);
    for (let i = 0; i < 5; i++) { gl.disableVertexAttribArray(i); gl.vertexAttribDivisor(i, 0); }
    gl.enableVertexAttribArray(0); gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 28, 0);
    gl.enableVertexAttribArray(1); gl.vertexAttribPointer(1, 4, gl.FLOAT, false, 28, 12);
    gl.drawArrays(gl.TRIANGLES, 0, list.length / 7);
  }
  stroke(list, m, half, ratio) {
    if (!list.length) return;
    const gl = this.gl, values = new Float32Array(list);
    for (let i = 6; i < values.length; i += 11) values[i] *= 0.5 * ratio;
    gl.useProgram(this.strokes);
    gl.uniformMatrix4fv(gl.getUniformLocation(this.strokes, 'm'), false, m);
    gl.uniform2f(gl.getUniformLocation(this.strokes, 'size'), ...half);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.corner);
    gl.enableVertexAttribArray(0); gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 8, 0); gl.vertexAttribDivisor(0, 0);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.STREAM_DRAW);
    [[1, 3, 0], [2, 3, 12], [3, 1, 24], [4, 4, 28]].forEach(([at, size, offset]) => { gl.enableVertexAttribArray(at); gl.vertexAttribPointer(at, size, gl.FLOAT, false, 44, offset); gl.vertexAttribDivisor(at, 1); });
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, list.length / 11);
  }
}
class Flat {
  constructor(canvas) { this.context = canvas.getContext('2d', { willReadFrequently: true }); this.canvas = canvas; this.kind = 'canvas'; }
  pass(scenes, camera, [x, y, w, h], look, ratio) {
    const c = this.context, m = camera.matrix(w / h), top = this.canvas.height - y - h, near = 1e-3 + 0.01 * camera.distance;
    const css = k => `rgba(${Math.round(255 * k[0])},${Math.round(255 * k[1])},${Math.round(255 * k[2])},${k[3]})`;
    // What lies behind the eye is cut off.
    const clipped = points => {
      const out = [];
      points.forEach((a, i) => {
        const b = points[(i + 1) % points.length];
        if (a[3] >= near) out.push(a);
        if ((a[3] >= near) !== (b[3] >= near)) out.push(mixed(a, b, (near - a[3]) / (b[3] - a[3])));
      });
      return out;
    };
    const screen = p => [x + w * (0.5 + 0.5 * p[0] / p[3]), top + h * (0.5 - 0.5 * p[1] / p[3])];
    c.save(); c.beginPath(); c.rect(x, top, w, h); c.clip();
    c.fillStyle = css(look.sky); c.fillRect(x, top, w, h);
    const items = [], far = 200 * camera.distance + 50, [cx, cy] = camera.target;
    const fill = (points, k) => {
      const seen = clipped(points);
      if (seen.length < 3) return;
      c.beginPath(); seen.forEach((p, i) => { const [u, v] = screen(p); i ? c.lineTo(u, v) : c.moveTo(u, v); }); c.closePath();
      c.fillStyle = css(k); c.fill();
      if (k[3] === 1) { c.strokeStyle = c.fillStyle; c.lineWidth = 0.6; c.stroke(); }
    };
    if (look.floor !== undefined) fill([[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([i, j]) => transformed(m, [cx + i * far, cy + j * far, look.floor])), look.ground);
    for (const s of scenes) {
      for (const list of [s.under, s.solid, s.glass]) for (let i = 0; i < list.length; i += 21) {
        const p = [0, 7, 14].map(o => transformed(m, [list[i + o], list[i + o + 1], list[i + o + 2]]));
        items.push([p[0][3] + p[1][3] + p[2][3] + (list === s.under ? 1e9 : 0), p, list.slice(i + 3, i + 7), 0]);
      }
      for (let i = 0; i < s.lines.length; i += 11) {
        const p = [transformed(m, s.lines.slice(i, i + 3)), transformed(m, s.lines.slice(i + 3, i + 6))];
        items.push([1.5 * (p[0][3] + p[1][3]) - 0.01 * camera.distance, p, s.lines.slice(i + 7, i + 11), s.lines[i + 6]]);
      }
    }
    items.sort((a, b) => b[0] - a[0]);
    for (const [, p, k, weight] of items) {
      if (!weight) { fill(p, k); continue; }
      let [a, b] = p;
      if (a[3] < near && b[3] < near) continue;
      if (a[3] < near) a = mixed(a, b, (near - a[3]) / (b[3] - a[3]));
      if (b[3] < near) b = mixed(b, a, (near - b[3]) / (a[3] - b[3]));
      c.beginPath(); c.moveTo(...screen(a)); c.lineTo(...screen(b)); c.strokeStyle = css(k); c.lineWidth = weight * ratio; c.stroke();
    }
    c.restore();
  }
}
