// What is beside and over the picture: numbers at the controls, axes, the scale bar, what is picked.
const place_sign = () => number('axis') < 3 && normal[number('axis')] < 0 ? -1 : 1;
const put = (id, text) => { if (document.activeElement !== $(id)) $(id).value = text; };
function show_numbers() {
  const dots = as_points(), model = as_model() && (number('cut') >= 1 || dim === 2);
  const all = dots ? points : count;
  let some = shown, most = all;
  if (grouped && !dots) {
    some = most = 0;
    for (let t = 0, last = -1; t < count; t++) {
      most += +counts(t);
      if (state[t] && simplex_id[t] !== last) { some++; last = simplex_id[t]; }
    }
  }
  $('shown').textContent = model ? many(triangle_count, 'face') + ' of the model shown'
    : whole(some) + ' of ' + many(most, ...(dots ? ['point'] : simplex)) + ' shown';
  document.querySelector('.dots').hidden = !dots;
  canvas.setAttribute('aria-label', document.title + '. ' + $('shown').textContent + ', coloured by ' + array.name);
  const place = place_sign() * (offset * half / (number('axis') === 2 ? relief : 1) + dot(normal, middle));
  put('cut-is', number('cut') < 1 ? short(place, half) : 'no cut');
  put('relief-is', relief > 1 ? 'times ' + relief : 'as they are');
  for (const id of ['from', 'to']) put(id + '-is', short(limit(id), array.log ? 0 : array.high - array.low));
  put('explode-is', Math.round(100 * number('explode')) + ' %');
  put('size-is', short(number('size')));
}
// Numbers that are typed beside a slider, as the place of the slider.
const from_typed = {
  from: x => at_scale(array, x), to: x => at_scale(array, x), explode: x => x / 100, size: x => x, relief: x => x,
  cut: x => ((place_sign() * x - dot(normal, middle)) / half * (number('axis') === 2 ? relief : 1) - low)
    / (high - low)
};
let picked = null;                                      // { layer, i } as pick() returns it
const coordinates = i => [0, 1, 2].slice(0, flat ? 2 : 3).map(k =>
  +((k === 2 && dim === 2 ? height[i] : point[4 * i + k]) * half + middle[k]).toPrecision(7));
const corners_of = at => at.layer === 3 ? [at.i] : at.layer === 2 ? [...triangle.subarray(4 * at.i, 4 * at.i + 3)]
  : [...corner.subarray(4 * at.i, 4 * at.i + n)];
function describe(at, x, y) {                           // x, y: the corner nearest to that place is told, too
  const on_facets = a => [0, 1, 2, 3].map(k => values(a)[4 * at.i + k]).filter(is_value).map(x => told(a, x))
    .join(', ');
  const c = corners_of(at), told_values = arrays.filter(a => a.of_points === (at.layer === 3) && at.layer !== 2)
    .map(a => [a.name, a.of_facets ? on_facets(a) : told(a, value_at(a, at.i))]).filter(x => x[1])
    .map(x => x.join(' ')), point_text = i => 'point ' + point_id[i] + ' ('
      + coordinates(i).join(', ') + ')';
  if (at.layer === 3) return point_text(at.i) + '; ' + told_values.join('; ');
  const far = i => { const [a, b] = project(i); return Math.hypot(a - x, b - y); };
  const nearest = x === undefined ? null : c.reduce((a, b) => far(b) < far(a) ? b : a);
  if (grouped && at.layer === 1) return 'cell ' + simplex_id[at.i] + '; ' + told_values.join('; ');
  return (at.layer === 2 ? 'face ' + at.i : simplex[0] + ' ' + simplex_id[at.i])
    + '; points ' + c.map(i => point_id[i]).join(', ') + (told_values.length ? '; ' + told_values.join('; ') : '')
    + (nearest === null ? '' : '; nearest: ' + point_text(nearest));
}
function set_picked(at, x, y) {
  picked = at;
  $('picked').textContent = at ? describe(at, x, y) : '';
  look();
}
// To a point or simplex by its id in the mesh: it comes to the middle and is marked.
function go_to(kind, id) {
  const i = (kind === 3 ? point_id : simplex_id).indexOf(id);
  if (i < 0) {
    $('picked').textContent = 'None of that id is here.';
    return;
  }
  const c = corners_of({ layer: kind, i }), size = [0, 1, 2].map(k =>
    Math.max(...c.map(p => point[4 * p + k])) - Math.min(...c.map(p => point[4 * p + k])));
  target = [0, 1, 2].map(k => c.reduce((sum, p) => sum + point[4 * p + k], 0) / c.length);
  distance = Math.min(distance, Math.max(0.02, 4 * Math.hypot(...size) / TAN, kind === 3 ? 0.3 / TAN : 0));
  moved = true;
  set_picked({ layer: kind, i });
}
function draw_marks({ eye, right, up }) {
  $('axes').replaceChildren();
  for (const k of [0, 1, 2].slice(0, flat ? 2 : 3).sort((a, b) => eye[a] - eye[b])) {
    const x = 25 * right[k], y = -25 * up[k], stroke = ['#d55e00', '#009e73', '#0072b2'][k];
    $('axes').append(svg('line', { x1: 0, y1: 0, x2: x, y2: y, stroke }),
      svg('text', { x: 1.28 * x, y: 1.28 * y }, 'xyz'[k]));
  }
  const pixel = 2 * distance * TAN * half / Math.max(1, canvas.clientHeight), most = 140 * pixel;
  const ten = 10 ** Math.floor(Math.log10(most)), length = [5, 2, 1].find(x => x * ten <= most) * ten;
  $('bar').style.width = length / pixel + 'px';
  $('bar').textContent = +length.toPrecision(1);
  $('bar').title = parallel || flat ? 'length' : 'length at the middle of the view';
  $('mark').replaceChildren();
  if (!picked) return;
  const at = corners_of(picked).map(project);
  at.forEach(([x, y], i) => {
    for (const [a, b] of at.slice(i + 1)) $('mark').append(svg('line', { x1: x, y1: y, x2: a, y2: b }));
    $('mark').append(svg('circle', { cx: x, cy: y, r: picked.layer === 3 ? 7 : 3.5 }));
  });
}
