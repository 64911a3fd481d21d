// Drawing: WebGL 2.  Shaders, textures, the picture, and what lies under a pixel.

let gl = canvas.getContext('webgl2', { antialias: false, alpha: false });
let trouble = gl ? '' : 'no WebGL 2 here';
// All that goes in is the number of a vertex: shaders fetch what they need from textures, 4096 texels a row.
const HEAD = `#version 300 es
precision highp float; precision highp int; precision highp sampler2D; precision highp usampler2D;
uniform mat4 camera; uniform mat3 axes; uniform vec3 surface, ink; uniform vec4 plane;
uniform int n, of, classes, plain, draw, clip, lit, grouped, dark;
uniform uint bit, layer; uniform float explode, size;
uniform sampler2D points, values, colours; uniform usampler2D corners, ids;
ivec2 texel(uint i) { return ivec2(i & 4095u, i >> 12); }
`;
// of: values are of 0 simplices, 1 points, 2 facets.
const PLACE = HEAD + `
out vec3 edge, weight, at; flat out vec3 value, normal; flat out int bared; flat out uint id;
vec3 p[4]; float x[4], s[4];
vec3 load(uint t) {
  uvec4 c = texelFetch(corners, texel(t), 0);
  vec3 sum = vec3(0);
  for (int k = 0; k < n; k++) {
    p[k] = texelFetch(points, texel(c[k]), 0).xyz;
    x[k] = texelFetch(values, texel(of == 1 ? c[k] : of == 2 ? 4u * t + uint(k) : t), 0).x;
    s[k] = dot(plane.xyz, p[k]) - plane.w;
    sum += p[k];
  }
  return grouped == 1 ? p[0] : sum / float(n);
}
void emit(int k, vec3 a, vec3 b, vec3 c, vec3 centre) {
  at = k == 0 ? a : k == 1 ? b : c;
  edge = weight = vec3(k == 0, k == 1, k == 2);
  normal = cross(b - a, c - a);
  normal /= max(length(normal), 1e-30);
  gl_Position = camera * vec4((at + explode * centre) / (1.0 + explode), 1);
}
`;
const FACET = PLACE + `
void main() {
  uint f = texelFetch(ids, texel(uint(gl_VertexID / 3)), 0).x;
  bared = f >= bit ? 1 : 0;
  f = f >= bit ? f - bit : f;
  uint i = f & 3u;
  ivec3 o = i == 0u ? ivec3(1, 2, 3) : i == 1u ? ivec3(0, 3, 2) : i == 2u ? ivec3(0, 1, 3) : ivec3(0, 2, 1);
  id = f >> 2;
  vec3 centre = load(id);
  emit(gl_VertexID % 3, p[o.x], p[o.y], p[o.z], centre);
  value = of == 2 ? vec3(x[i]) : vec3(x[o.x], x[o.y], x[o.z]);
  if (grouped == 1) edge.yz = vec2(1);
}`;
// The section of a tetrahedron: a triangle, or a quadrangle whose diagonal is no edge.
const CAP = PLACE + `
vec3 q[4]; float y[4]; bool inner[4];
void meet(int i, int a, int b) {
  inner[i] = grouped == 1 && min(a, b) == 0;
  float t = s[a] / (s[a] - s[b]);
  q[i] = mix(p[a], p[b], t);
  y[i] = of == 2 ? -1.0 : classes == 1 ? (t < 0.5 ? x[a] : x[b]) : mix(x[a], x[b], t);
}
void main() {
  int j = gl_VertexID % 6, o[4], m = 0, below;
  id = texelFetch(ids, texel(uint(gl_VertexID / 6)), 0).x;
  vec3 centre = load(id);
  for (int i = 0; i < 4; i++) if (s[i] <= 0.0) o[m++] = i;
  below = m;
  for (int i = 0; i < 4; i++) if (s[i] > 0.0) o[m++] = i;
  if (below == 2) {
    meet(0, o[0], o[2]); meet(1, o[0], o[3]); meet(2, o[1], o[3]); meet(3, o[1], o[2]);
  } else {
    for (int i = 0; i < 3; i++) meet(i, below == 1 ? o[0] : o[3], below == 1 ? o[i + 1] : o[i]);
  }
  ivec3 t = j < 3 ? ivec3(0, 1, 2) : ivec3(0, 2, 3);
  emit(j % 3, q[t.x], q[t.y], q[t.z], centre);
  value = vec3(y[t.x], y[t.y], y[t.z]);
  normal = plane.xyz;
  bared = 1;
  if (inner[t.y] || inner[t.z]) edge.x = 1.0;           // of a cell only what is on its facets is an edge
  if (inner[t.z] || inner[t.x]) edge.y = 1.0;
  if (inner[t.x] || inner[t.y]) edge.z = 1.0;
  if (below == 2 && j < 3) edge.y = 1.0;
  if (below == 2 && j >= 3) edge.z = 1.0;
  if (below != 2 && j >= 3) gl_Position = vec4(2, 2, 2, 1);
}`;
const COLOUR = `
const vec3 LIGHT = vec3(-0.436, 0.533, 0.726);
vec3 colour(float x) {
  if (x < 0.0) return surface;
  int i = classes == 1 ? int(x) & 255 : int(min(x, 1.0) * 255.0 + 0.5);
  return texelFetch(colours, ivec2(i, classes), 0).rgb;
}
`;
const SURFACE = HEAD + COLOUR + `
in vec3 edge, weight, at; flat in vec3 value, normal; flat in int bared;
out vec4 result;
void main() {
  if (clip == 1 && dot(plane.xyz, at) > plane.w) discard;
  float x = dot(weight, value);
  if (classes == 1) x = weight.x > max(weight.y, weight.z) ? value.x : weight.y > weight.z ? value.y
    : value.z;
  x = min(value.x, min(value.y, value.z)) < 0.0 ? -1.0 : x;
  bool bare = plain == 1 && bared == 0;
  vec3 c = bare ? surface : colour(x), m = normal * axes;
  float bright = max(dot(m.z < 0.0 ? -m : m, LIGHT), 0.0);
  c *= lit == 0 ? 1.0 : bare || n == 3 ? 0.44 + 0.64 * bright : 0.72 + 0.34 * bright;
  vec3 w = max(fwidth(edge), vec3(1e-9)), d = edge / w;
  float near = min(d.x, min(d.y, d.z)), tall = 1.0 / max(w.x, max(w.y, w.z));
  float line = (1.0 - smoothstep(0.4, 1.2, near)) * smoothstep(1.0, 8.0, tall);
  if (draw == 2 && near > 1.0) discard;
  result = vec4(mix(c, ink, draw == 3 ? line * (bare ? 0.24 : 0.5) : 0.0), 1);
}`;
// What is under a pixel: the layer (1 simplices, 2 the model, 3 points) and the number in it.
const PICK = HEAD + `
in vec3 at; flat in uint id; out uvec2 result;
void main() {
  if (clip == 1 && dot(plane.xyz, at) > plane.w) discard;
  result = uvec2(layer, id);
}`;
const DOT = HEAD + `
flat out float value; flat out uint id; out vec3 at;
void main() {
  uint i = texelFetch(ids, texel(uint(gl_VertexID)), 0).x;
  id = i;
  at = texelFetch(points, texel(i), 0).xyz;
  value = of == 1 ? texelFetch(values, texel(i), 0).x : -1.0;
  gl_Position = camera * vec4(at, 1);
  gl_PointSize = clamp(size / gl_Position.w, 1.5, 64.0);
}`;
const BALL = HEAD + COLOUR + `
flat in float value; out vec4 result;
void main() {
  vec2 d = 2.0 * gl_PointCoord - 1.0;
  float r = dot(d, d);
  if (r > 1.0) discard;
  float bright = max(dot(LIGHT, vec3(d.x, -d.y, sqrt(1.0 - r))), 0.0);
  result = vec4((dark == 1 ? ink : colour(value)) * (lit == 0 ? 1.0 : 0.5 + 0.55 * bright), 1);
}`;
const SCREEN = `#version 300 es
void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0, 1); }`;
// Obscurance: how much of the sky over a pixel the depth buffer around it hides (after McGuire, Osman,
// Bukowski and Hennessy 2011, 'The Alchemy screen-space ambient obscurance algorithm').
const SHADE = `#version 300 es
precision highp float; precision highp sampler2D;
uniform sampler2D picture, depth; uniform vec4 lens, range; uniform float reach; out vec4 result;
vec3 spot(ivec2 p) {                                    // at a depth z the view is lens.xy + z lens.zw wide and high
  float d = texelFetch(depth, p, 0).x, z = (range.x + range.y * d) / (range.z + range.w * d);
  return vec3((2.0 * (vec2(p) + 0.5) / vec2(textureSize(depth, 0)) - 1.0) * (lens.xy + z * lens.zw), -z);
}
void main() {
  ivec2 p = ivec2(gl_FragCoord.xy), most = textureSize(depth, 0) - 1;
  result = vec4(texelFetch(picture, p, 0).rgb, 1);
  if (reach <= 0.0 || texelFetch(depth, p, 0).x >= 1.0) return;
  ivec2 h = ivec2(1, 0), v = ivec2(0, 1);
  vec3 a = spot(p), l = a - spot(p - h), r = spot(p + h) - a, d = a - spot(p - v), u = spot(p + v) - a;
  vec3 normal = normalize(cross(abs(l.z) < abs(r.z) ? l : r, abs(d.z) < abs(u.z) ? d : u));
  float pixels = clamp(reach * float(most.y) / (2.0 * (lens.y - a.z * lens.w)), 4.0, 200.0), sum = 0.0;
  for (int i = 0; i < 32; i++) {
    float t = (float(i) + 0.5) / 32.0, angle = float(i) * 2.399963;
    vec3 to = spot(clamp(p + ivec2(round(pixels * t * vec2(cos(angle), sin(angle)))), ivec2(0), most)) - a;
    float far = length(to);
    sum += max(0.0, dot(normal, to) / max(far, 1e-9) - 0.12) * max(0.0, 1.0 - far / (2.0 * reach));
  }
  result.rgb *= mix(1.0, 0.42, min(1.0, sum / 11.0));
}`;

function program(vertex, fragment) {
  const out = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(out, shader);
  }
  gl.linkProgram(out);
  if (!gl.getProgramParameter(out, gl.LINK_STATUS)) {
    const logs = gl.getAttachedShaders(out).map(s => gl.getShaderInfoLog(s));
    throw new Error([gl.getProgramInfoLog(out), ...logs].join(' '));
  }
  const at = {};
  for (let i = 0; i < gl.getProgramParameter(out, gl.ACTIVE_UNIFORMS); i++) {
    const name = gl.getActiveUniform(out, i).name;
    at[name] = gl.getUniformLocation(out, name);
  }
  return { out, at };
}
const UNITS = ['points', 'values', 'colours', 'corners', 'ids', 'picture', 'depth'];
function texture(unit, internal, format, type, width, height, data) {
  const out = gl.createTexture();
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.bindTexture(gl.TEXTURE_2D, out);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  gl.texImage2D(gl.TEXTURE_2D, 0, internal, width, height, 0, format, type, data);
  return out;
}
const table = (unit, internal, format, type, data, each) =>
  texture(unit, internal, format, type, W, data.length / each / W, data);
let programs, buffers, value_data, pick_frame;
let cut_texture, id_texture, face_texture, corner_texture, triangle_texture, site_texture;
function set_up() {
  const most = gl.getParameter(gl.MAX_TEXTURE_SIZE);
  if (most < W || ids.length / W > most) throw new Error('too large for this graphics card');
  programs = { facet: program(FACET, SURFACE), cap: program(CAP, SURFACE), dot: program(DOT, BALL),
    shade: program(SCREEN, SHADE), pick_facet: program(FACET, PICK), pick_cap: program(CAP, PICK),
    pick_dot: program(DOT, PICK) };
  table(0, gl.RGBA32F, gl.RGBA, gl.FLOAT, point, 4);
  triangle_texture = table(3, gl.RGBA32UI, gl.RGBA_INTEGER, gl.UNSIGNED_INT, triangle, 4);
  corner_texture = table(3, gl.RGBA32UI, gl.RGBA_INTEGER, gl.UNSIGNED_INT, corner || new Uint32Array(4 * W), 4);
  face_texture = table(4, gl.R32UI, gl.RED_INTEGER, gl.UNSIGNED_INT, faces, 1);
  cut_texture = table(4, gl.R32UI, gl.RED_INTEGER, gl.UNSIGNED_INT, cut_ids, 1);
  site_texture = table(4, gl.R32UI, gl.RED_INTEGER, gl.UNSIGNED_INT, site_ids, 1);
  id_texture = table(4, gl.R32UI, gl.RED_INTEGER, gl.UNSIGNED_INT, ids, 1);
  const pixels = new Uint8Array([...scale, ...classes].flatMap(c => [...c, 255]));
  texture(2, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, 256, 2, pixels);
  value_data = new Float32Array(rows(Math.max(arrays.some(a => a.of_facets) ? 4 * count : count, points), 1));
  table(1, gl.R32F, gl.RED, gl.FLOAT, value_data, 1);
}
function upload_points() {
  gl.activeTexture(gl.TEXTURE0);
  gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, W, point.length / 4 / W, gl.RGBA, gl.FLOAT, point);
}
function upload_values() {
  const a = array, size = a.value.length;
  for (let i = 0; i < size; i++) {
    const x = a.value[i];
    value_data[i] = !is_value(x) ? -1 : a.classes ? x : Math.max(0, Math.min(1, at_scale(a, x)));
  }
  gl.activeTexture(gl.TEXTURE1);
  gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, W, value_data.length / W, gl.RED, gl.FLOAT, value_data);
}
function upload_ids(texture, data, size) {
  gl.activeTexture(gl.TEXTURE4);
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, W, Math.ceil(size / W), gl.RED_INTEGER, gl.UNSIGNED_INT, data);
}
// Where is drawn: four samples a pixel, then one, with depths, for shading.
function resize() {
  const ratio = Math.min(2, window.devicePixelRatio || 1);
  const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
  const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
  if (buffers && canvas.width === width && canvas.height === height) return;
  canvas.width = width; canvas.height = height;
  if (buffers) {
    buffers.frames.forEach(x => gl.deleteFramebuffer(x));
    buffers.stores.forEach(x => gl.deleteRenderbuffer(x));
    buffers.textures.forEach(x => gl.deleteTexture(x));
  }
  const samples = Math.min(4, gl.getParameter(gl.MAX_SAMPLES));
  const frames = [gl.createFramebuffer(), gl.createFramebuffer()];
  const stores = [gl.RGBA8, gl.DEPTH_COMPONENT24].map(format => {
    const out = gl.createRenderbuffer();
    gl.bindRenderbuffer(gl.RENDERBUFFER, out);
    gl.renderbufferStorageMultisample(gl.RENDERBUFFER, samples, format, width, height);
    return out;
  });
  const textures = [texture(5, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, width, height, null),
    texture(6, gl.DEPTH_COMPONENT24, gl.DEPTH_COMPONENT, gl.UNSIGNED_INT, width, height, null)];
  [gl.COLOR_ATTACHMENT0, gl.DEPTH_ATTACHMENT].forEach((place, i) => {
    gl.bindFramebuffer(gl.FRAMEBUFFER, frames[0]);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, place, gl.RENDERBUFFER, stores[i]);
    gl.bindFramebuffer(gl.FRAMEBUFFER, frames[1]);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, place, gl.TEXTURE_2D, textures[i], 0);
  });
  buffers = { frames, stores, textures };
}
function use(p, values) {
  gl.useProgram(p.out);
  for (const name in p.at) {
    const unit = UNITS.indexOf(name), x = values[name], at = p.at[name];
    if (unit >= 0) gl.uniform1i(at, unit);
    else if (name === 'bit' || name === 'layer') gl.uniform1ui(at, x);
    else if (['explode', 'size', 'reach'].includes(name)) gl.uniform1f(at, x);
    else if (typeof x === 'number') gl.uniform1i(at, x);
    else if (x.length === 16) gl.uniformMatrix4fv(at, false, x);
    else if (x.length === 9) gl.uniformMatrix3fv(at, false, x);
    else if (x.length === 4) gl.uniform4fv(at, x);
    else gl.uniform3fv(at, x);
  }
}
const hex = text => [1, 3, 5].map(i => parseInt(text.slice(i, i + 2), 16) / 255);
const bind = (unit, what) => { gl.activeTexture(gl.TEXTURE0 + unit); gl.bindTexture(gl.TEXTURE_2D, what); };
function uniforms(view) {
  return { camera: new Float32Array(view.matrix), axes: new Float32Array([...view.right, ...view.up, ...view.eye]),
    surface: hex(css('--surface')), ink: [0.04, 0.07, 0.11], plane: [...normal, offset], n, dark: 0,
    of: array.of_facets ? 2 : +array.of_points,
    classes: +array.classes, plain: +$('plain').checked, draw: number('draw'), clip: 0, lit: +!flat,
    grouped: +grouped,
    bit: count ? 4 * count : 1, layer: 1, explode: number('explode'),
    size: number('size') * canvas.height / TAN * Math.min(0.02, (flat ? 0.7 : 1.3) / Math.sqrt(points))
      / (parallel ? distance : 1) };
}
// Draws what select() chose, by the programs for pictures or for picking.
function draw_scene(values, facet, cap, dot) {
  bind(4, id_texture);
  if (as_points()) {
    use(dot, { ...values, layer: 3 });
    gl.drawArrays(gl.POINTS, 0, facets);
    return;
  }
  if (as_model()) {                                     // point values colour it; those of simplices do not
    const cutting = !flat && number('cut') < 1, one_colour = values.plain || !array.of_points;
    bind(3, triangle_texture); bind(4, face_texture);
    use(facet, { ...values, n: 3, layer: 2, plain: +one_colour, clip: +cutting, bit: 4 * triangle_count + 4 });
    gl.drawArrays(gl.TRIANGLES, 0, 3 * triangle_count);
    bind(3, corner_texture); bind(4, id_texture);
    if (!cutting || dim === 2) return;
  }
  use(facet, { ...values, clip: caps ? 1 : 0 });
  gl.drawArrays(gl.TRIANGLES, 0, 3 * facets);
  if (caps) {
    bind(4, cut_texture);
    use(cap, values);
    gl.drawArrays(gl.TRIANGLES, 0, 6 * caps);
  }
  if (sites) {                                          // in space cells hide them
    bind(4, site_texture);
    if (flat) gl.disable(gl.DEPTH_TEST);
    use(dot, { ...values, layer: 3, dark: 1 });
    gl.drawArrays(gl.POINTS, 0, sites);
    gl.enable(gl.DEPTH_TEST);
  }
}
// What is at that place of the canvas: a window of 65 pixels around it, as points reach into it from beside.
const WINDOW = 65;
function pick(x, y) {
  if (!gl || !buffers) return null;
  if (!pick_frame) {
    const frame = gl.createFramebuffer(), depth = gl.createRenderbuffer();
    const what = texture(5, gl.RG32UI, gl.RG_INTEGER, gl.UNSIGNED_INT, WINDOW, WINDOW, null);
    bind(5, buffers.textures[0]);
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, what, 0);
    gl.bindRenderbuffer(gl.RENDERBUFFER, depth);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, WINDOW, WINDOW);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
    pick_frame = frame;
  }
  const view = camera(), m = view.matrix, a = 2 * x / canvas.clientWidth - 1, b = 1 - 2 * y / canvas.clientHeight;
  for (let k = 0; k < 4; k++) {
    m[4 * k] = (m[4 * k] - a * m[4 * k + 3]) * canvas.width / WINDOW;
    m[4 * k + 1] = (m[4 * k + 1] - b * m[4 * k + 3]) * canvas.height / WINDOW;
  }
  gl.bindFramebuffer(gl.FRAMEBUFFER, pick_frame);
  gl.viewport(0, 0, WINDOW, WINDOW);
  gl.enable(gl.DEPTH_TEST);
  gl.clearBufferuiv(gl.COLOR, 0, new Uint32Array(4));
  gl.clearBufferfv(gl.DEPTH, 0, new Float32Array([1]));
  draw_scene(uniforms(view), programs.pick_facet, programs.pick_cap, programs.pick_dot);
  const out = new Uint32Array(4);
  gl.readPixels(WINDOW >> 1, WINDOW >> 1, 1, 1, gl.RGBA_INTEGER, gl.UNSIGNED_INT, out);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  return out[0] ? { layer: out[0], i: out[1] } : null;
}
let selected = false, asked = false;
function paint() {
  asked = false;
  if (!selected) {
    select();
    selected = true;
    if (gl) {
      upload_ids(id_texture, ids, facets);
      if (caps) upload_ids(cut_texture, cut_ids, caps);
      if (sites) upload_ids(site_texture, site_ids, sites);
    }
  }
  show_numbers();
  if (!gl) return;
  resize();
  const view = camera(), { near, far } = view, wide = [TAN * aspect(), TAN];
  gl.bindFramebuffer(gl.FRAMEBUFFER, buffers.frames[0]);
  gl.viewport(0, 0, canvas.width, canvas.height);
  gl.clearColor(...hex(css('--paper')), 1);
  gl.enable(gl.DEPTH_TEST);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  draw_scene(uniforms(view), programs.facet, programs.cap, programs.dot);
  gl.bindFramebuffer(gl.READ_FRAMEBUFFER, buffers.frames[0]);
  gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, buffers.frames[1]);
  gl.blitFramebuffer(0, 0, canvas.width, canvas.height, 0, 0, canvas.width, canvas.height,
    gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT, gl.NEAREST);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  gl.disable(gl.DEPTH_TEST);
  use(programs.shade, { reach: flat || number('draw') === 2 ? 0 : 0.25,
    lens: parallel ? [...wide.map(x => distance * x), 0, 0] : [0, 0, ...wide],
    range: parallel ? [near, far - near, 1, 0] : [far * near, 0, far, near - far] });
  gl.drawArrays(gl.TRIANGLES, 0, 3);
  draw_marks(view);
}
const look = () => { if (!asked) { asked = true; requestAnimationFrame(paint); } };
const change = () => { selected = false; look(); };
