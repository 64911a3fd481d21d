const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = a => { const l = Math.hypot(...a) || 1; return a.map(x => x / l); };
const UP = unit(lens.slice(7, 10)), SIDE = unit(cross(UP, Math.abs(dot(UP, unit(EYE))) < 0.999 ? EYE :
  Math.abs(UP[1]) < 0.9 ? [0, -1, 0] : [0, 0, 1])), FRONT = cross(SIDE, UP);
let turn, lift, distance, target, normal, offset, low, high, shown = 0, facets = 0, caps = 0;
let array = arrays.find(a => a.name === given.colour) || arrays[0];
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
  const [eye, right, up] = frame(), step = Math.max(1, points >> 16), box = [1e9, -1e9, 1e9, -1e9];
  for (let pass = 0; pass < 2; pass++) {                             // first the middle, then how far
    distance = pass ? 0 : distance;
    for (let i = 0; i < points; i += step) {
      const p = [0, 1, 2].map(k => point[4 * i + k] - (pass ? target[k] : 0));
      const x = dot(p, right), y = dot(p, up);
      if (pass) {
        distance = Math.max(distance,
          dot(p, eye) + 1.06 * Math.max(Math.abs(x) / aspect(), Math.abs(y)) / TAN);
      } else {
        box[0] = Math.min(box[0], x); box[1] = Math.max(box[1], x);
        box[2] = Math.min(box[2], y); box[3] = Math.max(box[3], y);
      }
    }
    if (!pass) target = [0, 1, 2].map(k => (box[0] + box[1]) / 2 * right[k] + (box[2] + box[3]) / 2 * up[k]);
  }
  distance = Math.max(distance, 1e-6);
}
const across = i => normal[0] * point[4 * i] + normal[1] * point[4 * i + 1] + normal[2] * point[4 * i + 2];
// Heights over the plane, times a factor; their range is at least a sixth of the others', if that does it.
const height = Float32Array.from({ length: points }, (_, i) => point[4 * i + 2]);
let relief = 1;
function set_relief(factor) {
  relief = factor;
  for (let i = 0; i < points; i++) point[4 * i + 2] = relief * height[i];
  if (gl) upload_points();
  set_normal(normal);
}
function own_relief() {
  const most = height.reduce((a, b) => Math.max(a, Math.abs(b)), 0);
  return dim === 2 && most > 0 ? Math.max(1, Math.min(20, Math.round(0.3 / most))) : 1;
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
  const eye = unit(EYE), along = [0, 1, 2].filter(k => CUT[k]);
  lift = flat ? Math.PI / 2 : Math.asin(Math.max(-1, Math.min(1, dot(eye, UP))));
  turn = flat ? 0 : Math.atan2(dot(eye, SIDE), dot(eye, FRONT));
  if (along.length) {
    set_normal(unit(CUT.slice(0, 3)));
    $('axis').value = along.length > 1 ? 4 : along[0];
  } else {
    const size = eye.map(Math.abs);
    $('axis').value = size.indexOf(Math.max(...size));
    face(eye);
  }
  $('cut').value = flat ? 1 : CUT[3];
  $('relief').value = own_relief();
  if (dim === 2) set_relief(number('relief'));
  $('explode').value = 0; $('size').value = 1; $('draw').value = count ? 3 : 4; $('cap').value = given.cap;
  $('plain').checked = dim === 3 && count > 0 && given.plain === '1';
  fit();
  set_array(array);
}
