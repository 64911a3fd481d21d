// Measures of simplices, from coordinates in single precision (of a surface over the plane: in the plane).
function measures() {
  const out = {};
  for (const k of ['least', 'largest', 'aspect', 'size', 'shortest', 'longest']) out[k] = new Float32Array(count);
  const p = [[0, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0]], degrees = 180 / Math.PI;
  const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
  const angle = (a, b) => degrees * Math.atan2(Math.hypot(...cross(a, b)), dot(a, b));
  for (let t = 0; t < count; t++) {
    let short = Infinity, long = 0, least = 180, largest = 0, around = 0;
    for (let a = 0; a < n; a++) for (let k = 0; k < dim; k++) p[a][k] = point[4 * corner[4 * t + a] + k];
    for (let a = 0; a < n; a++) for (let b = a + 1; b < n; b++) {
      const length = Math.hypot(p[a][0] - p[b][0], p[a][1] - p[b][1], p[a][2] - p[b][2]);
      short = Math.min(short, length); long = Math.max(long, length);
      around += length;
      const [c, d] = [0, 1, 2, 3].filter(x => x !== a && x !== b), e = minus(p[b], p[a]);
      const x = dim === 3 ? angle(cross(e, minus(p[c], p[a])), cross(e, minus(p[d], p[a])))
        : angle(minus(p[a], p[c]), minus(p[b], p[c]));
      least = Math.min(least, x); largest = Math.max(largest, x);
    }
    const u = minus(p[1], p[0]), v = minus(p[2], p[0]), w = minus(p[3], p[0]), uv = cross(u, v);
    const size = dim === 3 ? Math.abs(dot(uv, w)) / 6 : Math.abs(uv[2]) / 2;
    if (dim === 3) {                                    // the inradius: 3 volume / area of the faces
      around = (Math.hypot(...uv) + Math.hypot(...cross(v, w)) + Math.hypot(...cross(w, u))
        + Math.hypot(...cross(minus(v, u), minus(w, u)))) / 2;
    }
    const radius = dim * size / around;
    out.least[t] = least; out.largest[t] = largest;
    out.aspect[t] = Math.min(1e30, long / ((dim === 3 ? 2 * Math.sqrt(6) : 2 * Math.sqrt(3)) * radius));
    out.size[t] = size * half ** dim;
    out.shortest[t] = short * half; out.longest[t] = long * half;
  }
  return out;
}

// What colours can show: name, values (of simplices, or of points), classes or a scale.
const arrays = [];
function add_array(name, value, of_points, classes, integer, about = '', log = false) {
  const sorted = value.filter(x => x === x && Math.abs(x) < 1e38).sort(), m = sorted.length;
  let low = m ? sorted[0] : 0, high = m ? sorted[m - 1] : 0, sum = 0;
  for (let i = 0; i < m; i++) sum += sorted[i];
  const a = { name, value, of_points, classes, integer, low, high, least: low, largest: high,
    mean: m ? sum / m : 0, hundredth: m ? sorted[m / 100 | 0] : 0,
    about, log };
  if (log) {                                            // from the least that is above 0, or a millionth of the top
    a.high = Math.max(a.high, 1e-30);
    a.low = Math.max(a.high / 1e6, sorted.find(x => x > 0) || 0);
  }
  if (name === 'quality' && !integer) { a.low = 0; a.high = 1; }
  arrays.push(a);
}
if (count) {
  const m = measures(), solid = dim === 3, add = (name, value, about, log) =>
    add_array(name, value, false, false, false, about, log);
  add('quality', quality(), 'Mean ratio: ' + (solid ? '12 (3 volume)^(2/3)' : '4 sqrt(3) area')
    + ' / sum of squared edges; 1 regular, 0 flat.');
  add(solid ? 'least dihedral angle' : 'least angle', m.least, 'Degrees' + (solid ? ' between faces; 70.5' : '; 60')
    + ' in the regular ' + (solid ? 'tetrahedron.' : 'triangle.'));
  add(solid ? 'largest dihedral angle' : 'largest angle', m.largest, 'Degrees; near 180: flat.');
  add('aspect ratio', m.aspect, 'Longest edge / (' + (solid ? '2 sqrt(6)' : '2 sqrt(3)')
    + ' inradius); 1 regular, larger is worse.  Logarithmic.', true);
  add(solid ? 'volume' : 'area', m.size, 'Of each ' + (solid ? 'tetrahedron' : 'triangle') + '.  Logarithmic.', true);
  add('shortest edge', m.shortest, 'Length.  Logarithmic.', true);
  add('longest edge', m.longest, 'Length.  Logarithmic.', true);
}
add_array('order', Float32Array.from(point_id), true, false, true, 'Id in the input.');
for (const node of [...document.querySelectorAll('script[data-name]')]) {
  const d = node.dataset, size = d.of === 'points' ? points : count;
  let value;
  if (d.kind === 'real') {
    value = new Float32Array(bytes(node).buffer);
  } else {
    const number = reader(bytes(node));
    value = new Float32Array(size);
    for (let i = 0, last = 0; i < size; i++) {          // differences: 0 -1 1 -2 2 ... are 0 1 2 3 4 ...
      const x = number();
      last += x % 2 ? -(x + 1) / 2 : x / 2;
      value[i] = last;
    }
  }
  add_array(d.name, value, d.of === 'points', d.kind === 'classes', d.kind !== 'real');
}
const up = flat ? 1 : 2;
if (!flat || !arrays.some(a => a.of_points)) {
  const value = Float32Array.from({ length: points }, (_, i) => point[4 * i + up] * half + middle[up]);
  add_array(dim === 2 && !flat ? 'height' : 'xyz'[up], value, true, false, false);
}
