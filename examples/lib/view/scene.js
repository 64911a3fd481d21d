// Scene: which simplices, faces and points are drawn, from cut, limits, body and mode.  In: the controls; out: ids,
// facets, cut_ids, caps, shown.

function limit(id) {                                    // the value of a slider
  const x = off_scale(array, number(id));
  return array.integer ? Math.round(x) : x;
}
const ids = new Uint32Array(rows(Math.max(4 * count, points), 1));
const faces = new Uint32Array(triangle_count ? rows(triangle_count, 1) : W);
for (let i = 0; i < triangle_count; i++) faces[i] = 4 * i + 3;
const cut_ids = new Uint32Array(dim === 3 ? rows(count, 1) : W), state = new Uint8Array(count);
const side = new Float32Array(points), site_ids = new Uint32Array(grouped ? rows(points, 1) : W);
let sites = 0;
const MOST_EXPLODED = 500000;
const as_model = () => triangle_count > 0 && $('show').value === '1' && $('draw').value !== '4';
const as_points = () => !as_model() && (!count || $('draw').value === '4');

// The simplices that may be shown: not those outside the model; else not slivers that the hull joins by slivers.
const body = new Uint8Array(count), SLIVER = 0.05;
let hidden = 0;
function set_body() {
  body.fill(1);
  if (inside && !$('outside').checked) {
    body.set(inside);
  } else if (dim === 3 && count && $('slivers').checked && !inside && !grouped) {
    const stack = [];
    const take = t => { if (body[t] && value_at(arrays[0], t) < SLIVER) { body[t] = 0; stack.push(t); } };
    for (let f = 0; f < 4 * count; f++) if (other[f] < 0) take(f >> 2);
    while (stack.length) {
      const t = stack.pop();
      for (let f = 4 * t; f < 4 * t + 4; f++) if (other[f] >= 0) take(other[f] >> 2);
    }
  }
  if (!body.includes(1)) body.fill(1);
  hidden = 0;
  for (let t = 0; t < count; t++) hidden += !body[t];
}
function select() {
  const sites_only = grouped && $('sites').checked;
  const from = number('from') > 0 ? limit('from') : -Infinity;
  const to = number('to') < 1 ? limit('to') : Infinity;
  const all = from === -Infinity && to === Infinity;
  const cutting = !flat && number('cut') < 1, cap = number('cap') && dim === 3, value = array.value;
  const fits = x => all || x >= from && x <= to;
  offset = low + number('cut') * (high - low);
  for (let i = 0; i < points; i++) {
    side[i] = cutting ? across(i) - offset : -1;
  }
  shown = facets = caps = sites = 0;
  for (let t = 0; sites_only && t < count; t++) {
    if (counts(t) && side[corner[4 * t]] <= 0) site_ids[sites++] = corner[4 * t];
  }
  if (as_points() && sites_only) {
    ids.set(site_ids.subarray(0, sites));
    shown = facets = sites;
    return;
  }
  if (as_points()) {
    for (let i = 0; i < points; i++) {
      if (side[i] <= 0 && (!array.of_points || fits(value[i]))) ids[facets++] = i;
    }
    shown = facets;
    return;
  }
  for (let t = 0; t < count; t++) {
    const c = 4 * t, a = side[corner[c]], b = side[corner[c + 1]], d = side[corner[c + 2]];
    const e = dim === 3 ? side[corner[c + 3]] : d;
    let s = all ? 1 : 0;
    if (!all) {
      s = array.of_facets ? 0 : 1;
      for (let k = 0; k < n; k++) {
        if (array.of_facets) s |= fits(value[c + k]);
        else s &= fits(value[array.of_points ? corner[c + k] : t]);
      }
    }
    if (s && cutting) {
      if (cap) {
        s = a <= 0 || b <= 0 || d <= 0 || e <= 0 ? 1 : 0;
        if (s && (a > 0 || b > 0 || d > 0 || e > 0)) cut_ids[caps++] = t;
      } else {
        s = (grouped ? a : a + b + d + (dim === 3 ? e : 0)) <= 0 ? 1 : 0;
      }
    }
    s &= body[t];
    if (!s && cap && caps && cut_ids[caps - 1] === t) caps--;
    state[t] = s;
    shown += s;
  }
  if (dim === 2) {
    for (let t = 0; t < count; t++) if (state[t]) ids[facets++] = 4 * t + 3;
    return;
  }
  const model = as_model(), apart = !model && (number('explode') > 0 || number('draw') === 2);
  if (apart && shown > MOST_EXPLODED) peel();
  for (let f = 0; f < 4 * count; f++) {
    if (state[f >> 2] === 1) {
      const g = other[f];
      if (grouped && (f & 3) !== 0) continue;
      if (!apart && g >= 0 && state[g >> 2]) continue;
      const bared = g >= 0 && body[g >> 2] && (cap || !state[g >> 2]);
      if (model && !bared && (!cutting || cap || !crosses(f >> 2))) continue;
      ids[facets++] = bared || apart && g >= 0 ? 4 * count + f : f;
    }
  }
}
const crosses = t => [0, 1, 2, 3].some(k => side[corner[4 * t + k]] > 0);
// Exploded and many: only the outer layers are drawn, state 1; what lies deeper, state 2, they hide.
function peel() {
  let budget = MOST_EXPLODED, layer = 3, left = shown, grown = 1;
  for (let t = 0; t < count; t++) if (state[t]) state[t] = 2;
  while (left > 0 && budget > 0 && grown) {
    grown = 0;
    for (let t = 0; t < count; t++) {
      let outer = false;
      for (let f = 4 * t; state[t] === 2 && f < 4 * t + 4; f++) {
        const g = other[f] >> 2;
        outer = outer || g < 0 || !state[g] || state[g] > 2 && state[g] < layer;
      }
      if (outer) { state[t] = layer; grown++; }
    }
    budget -= grown; left -= grown; layer++;
  }
  for (let t = 0; t < count; t++) if (state[t] > 2) state[t] = 1;
}
