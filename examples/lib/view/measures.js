// Measures: what colours can show.  Each array is computed, or decoded, at its first use: values(a) returns it whole,
// value_at(a, i) one value, and summarise(a) adds its range, mean and histogram.

// Measures of simplices, from coordinates in single precision (of a mesh over the plane: in the plane).  Corners
// of the simplex that is measured, three coordinates each; a, b, c, d are places in this array.
const xyz = new Float64Array(12);
const SOLID = dim === 3;
// The two corners of each edge, then the other two, or one twice.
const EDGES = Uint8Array.from(SOLID
  ? [0, 3, 6, 9, 0, 6, 3, 9, 0, 9, 3, 6, 3, 6, 0, 9, 3, 9, 0, 6, 6, 9, 0, 3] : [0, 3, 6, 6, 0, 6, 3, 3, 3, 6, 0, 0]);
const REGULAR = SOLID ? 2 * Math.sqrt(6) : 2 * Math.sqrt(3);      // longest edge / inradius

// The dot product of b - a and c - a.
function dot_at(a, b, c) {
  return (xyz[b] - xyz[a]) * (xyz[c] - xyz[a]) + (xyz[b + 1] - xyz[a + 1]) * (xyz[c + 1] - xyz[a + 1])
    + (xyz[b + 2] - xyz[a + 2]) * (xyz[c + 2] - xyz[a + 2]);
}
// Twice the area of the triangle a b c.
function two_areas(a, b, c) {
  const x = xyz[b] - xyz[a], y = xyz[b + 1] - xyz[a + 1], z = xyz[b + 2] - xyz[a + 2];
  const u = xyz[c] - xyz[a], v = xyz[c + 1] - xyz[a + 1], w = xyz[c + 2] - xyz[a + 2];
  return Math.sqrt((y * w - z * v) ** 2 + (z * u - x * w) ** 2 + (x * v - y * u) ** 2);
}
// Loads the corners of simplex t; returns 6 volumes of a tetrahedron, 2 areas of a triangle.
function load_simplex(t) {
  for (let a = 0; a < n; a++) {
    const p = 4 * corner[4 * t + a];
    for (let k = 0; k < space; k++) xyz[3 * a + k] = point[p + k];
  }
  if (!SOLID) return two_areas(0, 3, 6);
  const x = xyz[3] - xyz[0], y = xyz[4] - xyz[1], z = xyz[5] - xyz[2];
  const u = xyz[6] - xyz[0], v = xyz[7] - xyz[1], w = xyz[8] - xyz[2];
  return Math.abs((y * w - z * v) * (xyz[9] - xyz[0]) + (z * u - x * w) * (xyz[10] - xyz[1])
    + (x * v - y * u) * (xyz[11] - xyz[2]));
}
function quality(t) {
  const size = load_simplex(t);
  let sum = 0;
  for (let i = 0; i < EDGES.length; i += 4) sum += dot_at(EDGES[i], EDGES[i + 1], EDGES[i + 1]);
  return sum > 0 ? Math.min(1, SOLID ? 12 * Math.cbrt(size * size / 4) / sum : 2 * Math.sqrt(3) * size / sum) : 0;
}
// The least angle has the largest cotangent, and all cotangents of a simplex have its size below.  At the edge e
// between faces with edges u and v: tan = |e| 6 volume / (e.e u.v - e.u e.v); in a triangle between u and v:
// tan = 2 area / u.v.
function angle(t, sign) {                               // sign: 1 for the least, -1 for the largest
  const size = load_simplex(t);
  let most = -Infinity;
  for (let i = 0; i < EDGES.length; i += 4) {
    const a = EDGES[i], b = EDGES[i + 1], c = EDGES[i + 2], d = EDGES[i + 3], e = dot_at(a, b, b);
    most = Math.max(most, sign * (!SOLID ? dot_at(c, a, b)
      : e > 0 ? (e * dot_at(a, c, d) - dot_at(a, b, c) * dot_at(a, b, d)) / Math.sqrt(e) : Infinity));
  }
  return 180 / Math.PI * Math.atan2(size, sign * most);
}
function edge(t, sign) {                                // sign: 1 for the longest, -1 for the shortest
  load_simplex(t);
  let most = -Infinity;
  for (let i = 0; i < EDGES.length; i += 4) {
    most = Math.max(most, sign * dot_at(EDGES[i], EDGES[i + 1], EDGES[i + 1]));
  }
  return Math.sqrt(sign * most) * half;
}
// The inradius is 3 volume / area of the faces, or 2 area / length of the edges.
function aspect_ratio(t) {
  const size = load_simplex(t);
  let long = 0, around = 0;
  for (let i = 0; i < EDGES.length; i += 4) {
    const length = Math.sqrt(dot_at(EDGES[i], EDGES[i + 1], EDGES[i + 1]));
    long = Math.max(long, length);
    around += length;
  }
  if (SOLID) around = two_areas(0, 3, 6) + two_areas(0, 3, 9) + two_areas(0, 6, 9) + two_areas(3, 6, 9);
  return Math.min(1e30, long * around / (REGULAR * size));
}

const arrays = [];
// of_points: one value a point, of_facets: one a facet, else one a simplex.  classes, integer, names: see pbw_view.h.
// all() returns the values, or one(i) returns the i-th.
function add_array(name, given) {
  const defaults = { of_points: false, of_facets: false, classes: false, integer: false, names: [], about: '',
    log: false, value: null };
  arrays.push({ name, ...defaults, ...given });
}
function values(a) {
  if (a.value) return a.value;
  if (a.all) return a.value = a.all();
  const size = a.of_points ? points : count, out = new Float32Array(size), one = a.one;
  for (let i = 0; i < size; i++) out[i] = one(i);
  return a.value = out;
}
const value_at = (a, i) => a.value || !a.one ? values(a)[i] : Math.fround(a.one(i));
const is_value = x => Math.abs(x) < 1e38;               // not NaN, not infinite
const told = (a, x) => a.names[x] || (is_value(x) ? short(x) : 'none');
const counted = (a, i) => a.of_points || a.of_facets || counts(i);
// A scale that shows most values: logarithmic where they are positive and span magnitudes, else without the
// hundredths at both ends where those take most of the range.
function suit_scale(a, rank) {
  const m = rank.length, first = rank[m / 100 | 0], last = rank[m - 1 - (m / 100 | 0)];
  if (m < 100 || a.classes || a.one || !(a.high > a.low)) return;
  if (first > 0 && last > 100 * first) {
    a.log = true;
    a.about = 'Logarithmic.';
  } else if (last > first && last - first < 0.25 * (a.high - a.low)) {
    a.low = first;
    a.high = last;
    a.about = 'Colours from the 1st to the 99th hundredth of the values.';
  }
}
// least, largest, mean, hundredth (a hundredth is below it) of the values; low and high of the scale.
function summarise(a) {
  if (a.bin) return;
  const value = values(a), sorted = new Float32Array(value.length);
  let m = 0, sum = 0;
  for (let i = 0; i < value.length; i++) {
    if (is_value(value[i]) && counted(a, i)) { sorted[m++] = value[i]; sum += value[i]; }
  }
  const rank = sorted.subarray(0, m).sort();
  a.least = a.low = m ? rank[0] : 0;
  a.largest = a.high = m ? rank[m - 1] : 0;
  a.mean = m ? sum / m : 0;
  a.hundredth = m ? rank[m / 100 | 0] : 0;
  suit_scale(a, rank);
  if (a.log) {                                          // from the least that is above 0, or a millionth of the top
    a.high = Math.max(a.high, 1e-30);
    a.low = Math.max(a.high / 1e6, rank.find(x => x > 0) || 0);
  }
  if (a.one === quality) { a.low = 0; a.high = 1; }
  a.bin = histogram(a);
}
// How many values lie in each of equal parts of the scale, or are each of few whole numbers.
function histogram(a) {
  const span = a.high - a.low, bins = a.integer && span < 64 ? span + 1 : 48, bin = new Float64Array(bins);
  for (let i = 0; i < a.value.length; i++) {
    const x = a.value[i], place = Math.max(0, at_scale(a, x)) * bins | 0;
    const k = bins === span + 1 ? x - a.low : Math.min(bins - 1, place);
    if (is_value(x) && counted(a, i)) bin[k]++;
  }
  return bin;
}
function add_measures() {
  const kind = SOLID ? 'dihedral angle' : 'angle';
  add_array('quality', { one: quality, about: 'Mean ratio: ' + (SOLID ? '12 (3 volume)^(2/3)' : '4 sqrt(3) area')
    + ' / sum of squared edges; 1 regular, 0 flat.' });
  add_array('least ' + kind, { one: t => angle(t, 1), about: 'Degrees'
    + (SOLID ? ' between faces; 70.5 in the regular tetrahedron.' : '; 60 in the regular triangle.') });
  add_array('largest ' + kind, { one: t => angle(t, -1), about: 'Degrees; near 180: flat.' });
  add_array('aspect ratio', { one: aspect_ratio, log: true, about: 'Longest edge / ('
    + (SOLID ? '2 sqrt(6)' : '2 sqrt(3)') + ' inradius); 1 regular, larger is worse.  Logarithmic.' });
  add_array(SOLID ? 'volume' : 'area', { one: t => load_simplex(t) * (SOLID ? half ** 3 / 6 : half ** 2 / 2),
    log: true, about: 'Of each ' + (SOLID ? 'tetrahedron' : 'triangle') + '.  Logarithmic.' });
  add_array('shortest edge', { one: t => edge(t, -1), log: true, about: 'Length.  Logarithmic.' });
  add_array('longest edge', { one: t => edge(t, 1), log: true, about: 'Length.  Logarithmic.' });
}
// An array that came with the page.
function add_given(node) {
  const { name, of, kind } = node.dataset, size = of === 'points' ? points : of === 'facets' ? 4 * count : count;
  const names = node.dataset.names ? node.dataset.names.split('\n') : [], NONE = 4294967295;
  const all = () => kind === 'real' ? new Float32Array(bytes(node).buffer)
    : read_steps(node, new Float32Array(size)).map(x => x >= NONE ? NaN : x);
  add_array(name, { of_points: of === 'points', of_facets: of === 'facets', classes: kind === 'classes',
    integer: kind !== 'real', names, all });
}
if (count && !grouped) add_measures();
if (!grouped) {
  add_array('order', {
    of_points: true, integer: true, about: 'Id in the input.', all: () => new Float32Array(point_id)
  });
}
document.querySelectorAll('script[data-name]').forEach(add_given);
const up = flat ? 1 : 2;
if (!flat || !arrays.some(a => a.of_points)) {
  add_array(dim === 2 && !flat && !surface ? 'height' : 'xyz'[up], { of_points: true,
    one: i => (SOLID || flat ? point[4 * i + up] : height[i]) * half + middle[up] });
}
