// Data: what the page carries becomes points, corners, neighbors, ids, the faces of the model.
// Cells (polygons), frames of an animation and regions would be decoded here, too.

function bytes(node) {
  const text = atob(node.textContent), out = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) out[i] = text.charCodeAt(i);
  node.remove();
  return out;
}
// Textures have whole rows of W texels.
const rows = (size, each) => Math.max(1, Math.ceil(size / W)) * W * each;

// A number with each call: seven bits a byte, the lowest first; all bytes but the last have the top bit.
function reader(raw) {
  let at = 0;
  return () => {
    let x = 0, unit = 1, b;
    do { b = raw[at++]; x += (b & 127) * unit; unit *= 128; } while (b > 127);
    return x;
  };
}

// Points are numbered as corners meet them: 0 is a new one, d the d-th last.
function read_corners() {
  const number = reader(bytes($('corners'))), corner = new Uint32Array(rows(count, 4));
  let next = 0;
  for (let i = 0; i < count * n; i++) {
    const d = number();
    corner[dim === 3 ? i : 4 * (i / 3 | 0) + i % 3] = d ? next - d : next++;
  }
  return corner;
}

function read_points() {
  const raw = new Float32Array(bytes($('points')).buffer), each = flat ? 2 : 3;
  const point = new Float32Array(rows(points, 4));
  for (let i = 0; i < points; i++) {
    for (let k = 0; k < each; k++) point[4 * i + k] = raw[each * i + k];
  }
  return point;
}

// Across each facet: the facet of the other tetrahedron, -1 on the hull.  A facet waits at its least point
// for its like.
function read_neighbors(corner) {
  const other = new Int32Array(4 * count).fill(-1), head = new Int32Array(points).fill(-1);
  const next = new Int32Array(4 * count);
  const low = new Uint32Array(4 * count), high = new Uint32Array(4 * count);
  for (let f = 0; f < 4 * count; f++) {
    const t = f & ~3;
    let a = corner[t + (f + 1 & 3)], b = corner[t + (f + 2 & 3)], c = corner[t + (f + 3 & 3)], x;
    if (a > b) { x = a; a = b; b = x; }
    if (b > c) { x = b; b = c; c = x; }
    if (a > b) { x = a; a = b; b = x; }
    let g = head[a], before = -1;
    while (g >= 0 && (low[g] !== b || high[g] !== c)) { before = g; g = next[g]; }
    if (g >= 0) {
      other[f] = g;
      other[g] = f;
      if (before < 0) head[a] = next[g]; else next[before] = next[g];
    } else {
      low[f] = b; high[f] = c; next[f] = head[a]; head[a] = f;
    }
  }
  return other;
}

// The middle and half the size of the box of the points; eye, up, cut of the options.
const lens = [...new Float64Array(bytes($('lens')).buffer)];
const middle = lens.slice(0, 3), half = lens[3], EYE = lens.slice(4, 7), CUT = lens.slice(10, 14);
const point = read_points(), corner = count ? read_corners() : null;
const other = count && dim === 3 ? read_neighbors(corner) : null;

// The ids that points and simplices have in the mesh of the program, runs of flags, the faces of the model.
function read_steps(node, out) {                        // differences: 0 -1 1 -2 2 ... are 0 1 2 3 4 ...
  const number = reader(bytes(node));
  for (let i = 0, last = 0; i < out.length; i++) {
    const x = number();
    out[i] = last += x % 2 ? -(x + 1) / 2 : x / 2;
  }
  return out;
}
function each_run(id, then) {                           // the first run is of zeros
  const raw = bytes($(id)), number = reader(raw);
  for (let i = 0, flag = 0; i < raw.length; flag = 1 - flag) {
    const size = number();
    then(flag, size);
    for (let x = size; x > 127; x = Math.floor(x / 128)) i++;
    i++;
  }
}
const point_id = read_steps($('ids'), new Uint32Array(points)), simplex_id = new Uint32Array(count);
if ($('kept')) {
  let id = 0, next = 0;
  each_run('kept', (kept, size) => {
    if (kept) for (let i = 0; i < size; i++) simplex_id[next++] = id + i;
    id += size;
  });
} else {
  for (let i = 0; i < count; i++) simplex_id[i] = i;
}
if (grouped) for (let i = 0; i < count; i++) simplex_id[i] = point_id[corner[4 * i]];
// Of a cell only its first simplex is counted.
const counts = i => !grouped || i === 0 || simplex_id[i] !== simplex_id[i - 1];
let inside = null;
if ($('inside')) {
  let next = 0;
  inside = new Uint8Array(count);
  each_run('inside', (flag, size) => inside.fill(flag, next, next += size));
}
const kept_only = given.kept === '1';
const triangle_count = +given.triangles, triangle = new Uint32Array(rows(triangle_count, 4));
if (triangle_count) {
  read_steps($('triangles'), new Uint32Array(3 * triangle_count)).forEach((p, i) => {
    triangle[4 * (i / 3 | 0) + i % 3] = p;
  });
}
