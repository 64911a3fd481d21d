// Camera: up, the eye, what is in the middle, how far; fitting, matrices, where a point is on the page.

// The box of the points.
const bottom = [9, 9, 9], extent = [-9, -9, -9];
for (let i = 0; i < points; i++) for (let k = 0; k < 3; k++) {
  const x = point[4 * i + k];
  if (x < bottom[k]) bottom[k] = x;
  if (x > extent[k]) extent[k] = x;
}
for (let k = 0; k < 3; k++) extent[k] -= bottom[k];

// Up: as given, or guessed: y where the body stands on a flat base across y and on less across z, or is much flatter
// in y than in x and z, as ground is; else z.
function guess_up() {
  const base = [0, 0, 0], corners = triangle_count ? triangle : corner, [wide, tall, deep] = extent;
  const at = (c, k) => point[4 * c + k], triangles = triangle_count || (dim === 2 ? count : 0);
  const facets = triangles || 4 * count, order = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];
  for (let f = 0; f < facets; f++) {
    if (!triangles && other[f] >= 0) continue;
    const c = triangles ? [0, 1, 2].map(k => corners[4 * f + k]) : order[f & 3].map(k => corners[(f & ~3) + k]);
    const [u, v] = [1, 2].map(j => [0, 1, 2].map(k => at(c[j], k) - at(c[0], k)));
    const area = cross(u, v), all = Math.hypot(...area);
    for (let k = 1; k < 3; k++) {
      const side = Math.abs(area[k]);
      if (side > 0.97 * all && at(c[0], k) < bottom[k] + 0.03 * extent[k]) base[k] += side / 2;
    }
  }
  const steady = [0, 1, 2].map(k => base[k] * extent[k] / Math.max(1e-30, wide * tall * deep));
  return steady[1] > 0.05 && steady[1] > 1.5 * steady[2] || tall < 0.4 * Math.min(wide, deep) && tall > 0 ? 1 : 2;
}
const has_facets = dim === 3 && count + triangle_count > 0;
let UP, SIDE, FRONT, home, parallel = false, moved = false;
const EYES = [[1, 0.5, 0.5], [0.55, 0.5, 1], [0.55, -1, 0.5]], FACES = [[1, 0, 0], [0, 0, 1], [0, -1, 0]];
const given_up = lens.slice(7, 10), has_up = Math.hypot(...given_up) > 0, has_eye = Math.hypot(...EYE) > 0;
function set_up_axis(k) {                               // 3: as given
  UP = k < 3 ? [0, 1, 2].map(i => +(i === k)) : unit(given_up);
  home = flat ? [0, -1, 0] : has_eye ? unit(EYE) : unit(k < 3 ? EYES[k] : EYES[Math.abs(UP[1]) > 0.9 ? 1 : 2]);
  const front = Math.abs(dot(UP, home)) < 0.999 ? home : FACES[k < 3 ? k : Math.abs(UP[1]) < 0.9 ? 2 : 1];
  SIDE = unit(cross(UP, front));
  FRONT = cross(SIDE, UP);
}
const first_up = flat ? 2 : has_up ? 3 : space === 2 ? 2 : guess_up();
function look_along(eye) {
  lift = flat ? Math.PI / 2 : Math.asin(Math.max(-1, Math.min(1, dot(eye, UP))));
  turn = flat ? 0 : Math.atan2(dot(eye, SIDE), dot(eye, FRONT));
}
let turn, lift, distance, target, normal, offset, low, high, shown = 0, facets = 0, caps = 0;
// Of points alone, their order in the input says least.
let array = arrays.find(a => a.name === given.colour) || !count && arrays.slice(1).find(a => a.of_points)
  || arrays[0];
const number = id => +$(id).value;

// To the viewer, right and up.
function frame() {
  const eye = [0, 1, 2].map(k => Math.cos(lift) * (Math.cos(turn) * FRONT[k] + Math.sin(turn) * SIDE[k])
    + Math.sin(lift) * UP[k]);
  const right = [0, 1, 2].map(k => -Math.sin(turn) * FRONT[k] + Math.cos(turn) * SIDE[k]);
  return [eye, right, cross(eye, right)];
}
const TAN = Math.tan(Math.PI / 12);
const aspect = () => Math.max(0.05, canvas.clientWidth / Math.max(1, canvas.clientHeight));
function fit() {
  const [eye, right, up] = frame(), step = Math.max(1, points >> 16), box = [1e9, -1e9, 1e9, -1e9], wide = aspect();
  for (let pass = 0; pass < 2; pass++) {                             // first the middle, then how far
    distance = pass ? 0 : distance;
    for (let i = 0; i < points; i += step) {
      const p = [0, 1, 2].map(k => point[4 * i + k] - (pass ? target[k] : 0));
      const x = dot(p, right), y = dot(p, up);
      if (pass) {
        distance = Math.max(distance,
          (parallel ? 0 : dot(p, eye)) + 1.06 * Math.max(Math.abs(x) / wide, Math.abs(y)) / TAN);
      } else {
        box[0] = Math.min(box[0], x); box[1] = Math.max(box[1], x);
        box[2] = Math.min(box[2], y); box[3] = Math.max(box[3], y);
      }
    }
    if (!pass) target = [0, 1, 2].map(k => (box[0] + box[1]) / 2 * right[k] + (box[2] + box[3]) / 2 * up[k]);
  }
  distance = Math.max(distance, 1e-6);
  moved = false;
}
// From coordinates to clip space, by columns; how far before the target it begins, and ends.
function camera() {
  const [eye, right, up] = frame(), reach = Math.hypot(...target) + 1.8 * relief;
  const near = parallel ? distance - reach : Math.max(distance - reach, distance * 0.01), far = distance + reach;
  const sx = 1 / (TAN * aspect()), sy = 1 / TAN, e = dot(eye, target), s = parallel ? 1 / distance : 1;
  const c = (parallel ? 2 : far + near) / (near - far);
  const d = (parallel ? far + near : 2 * far * near) / (near - far), w = parallel ? 0 : 1;
  const column = k => [s * sx * right[k], s * sy * up[k], c * eye[k], -w * eye[k]];
  const matrix = [...column(0), ...column(1), ...column(2), -s * sx * dot(right, target), -s * sy * dot(up, target),
    c * (-e - distance) + d, parallel ? 1 : e + distance];
  return { eye, right, up, near, far, matrix };
}
function project(i) {                                   // where point i is on the canvas
  const m = camera().matrix, p = [point[4 * i], point[4 * i + 1], point[4 * i + 2], 1];
  const clip = [0, 1, 3].map(r => p.reduce((sum, x, k) => sum + m[4 * k + r] * x, 0));
  return [canvas.clientWidth * (clip[0] / clip[2] + 1) / 2, canvas.clientHeight * (1 - clip[1] / clip[2]) / 2];
}
const across = i => normal[0] * point[4 * i] + normal[1] * point[4 * i + 1] + normal[2] * point[4 * i + 2];
// Heights over the plane, times a factor; their range is at least a sixth of the others', if that does it.
const height = new Float32Array(points);
for (let i = 0; i < points; i++) height[i] = point[4 * i + 2];
let relief = 1;
function set_relief(factor) {
  relief = factor;
  for (let i = 0; i < points; i++) point[4 * i + 2] = relief * height[i];
  if (gl) upload_points();
  set_normal(normal);
}
function own_relief() {
  const most = height.reduce((a, b) => Math.max(a, Math.abs(b)), 0);
  return space === 2 && most > 0 ? Math.max(1, Math.min(20, Math.round(0.3 / most))) : 1;
}
function set_normal(a) {
  normal = a;
  low = Infinity; high = -Infinity;
  for (let i = 0; i < points; i++) {
    const d = across(i);
    low = Math.min(low, d); high = Math.max(high, d);
  }
}
// The plane that the menu names, with the side to the viewer cut away.
function face(eye) {
  const k = number('axis');
  if (k < 4) set_normal(k === 3 ? eye : [0, 1, 2].map(i => i === k ? eye[k] < 0 ? -1 : 1 : 0));
}
function reset() {
  $('up').value = first_up;
  set_up_axis(first_up);
  const eye = home, along = [0, 1, 2].filter(k => CUT[k]);
  look_along(eye);
  $('projection').value = 0; parallel = false;
  $('show').value = triangle_count ? 1 : 0;
  $('outside').checked = $('sites').checked = false; $('slivers').checked = dim === 3 && count > 0 && !kept_only;
  if (along.length) {
    set_normal(unit(CUT.slice(0, 3)));
    $('axis').value = along.length > 1 ? 4 : along[0];
  } else {
    const seen = eye.map((x, k) => extent[k] > 0 ? Math.abs(x) : -1);
    $('axis').value = seen.indexOf(Math.max(...seen));
    face(eye);
  }
  $('cut').value = flat ? 1 : CUT[3];
  $('relief').value = own_relief();
  if (dim === 2) set_relief(number('relief'));
  $('explode').value = 0; $('size').value = 1; $('cap').value = given.cap;
  $('draw').value = count || triangle_count ? 3 : 4;
  $('plain').checked = has_facets && given.plain === '1';
  set_body();
  fit();
  set_array(array);
}
