// Panel: mouse, touch, keys, controls, the link; then the start.

const move = (dx, dy) => {                              // in pixels of the page
  const [, right, up] = frame(), step = 2 * distance * TAN / Math.max(1, canvas.clientHeight);
  moved = true;
  target = target.map((x, k) => x - step * (dx * right[k] - dy * up[k]));
  look();
};
const rotate = (dx, dy) => {
  if (flat) { move(dx, dy); return; }
  moved = true;
  turn -= 0.008 * dx;
  lift = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, lift + 0.008 * dy));
  look();
};
const zoom = (factor, x = 0, y = 0) => {                // x, y: the place that stays, from the middle
  const before = distance;
  distance = Math.max(1e-5, Math.min(100, distance * factor));
  const rest = 1 - distance / before;
  move(-x * rest * before / distance, -y * rest * before / distance);
};
const fingers = new Map();
canvas.addEventListener('pointerdown', e => {
  canvas.setPointerCapture(e.pointerId);
  $('tip').hidden = true;
  fingers.set(e.pointerId, { x: e.clientX, y: e.clientY, from: [e.offsetX, e.offsetY], far: 0,
    pans: e.button === 2 || e.shiftKey });
});
canvas.addEventListener('pointermove', e => {
  const f = fingers.get(e.pointerId);
  if (!f) { hover(e.offsetX, e.offsetY); return; }
  const dx = e.clientX - f.x, dy = e.clientY - f.y, second = [...fingers].find(([id]) => id !== e.pointerId);
  if (second) {
    const g = second[1], before = Math.hypot(f.x - g.x, f.y - g.y);
    const after = Math.hypot(e.clientX - g.x, e.clientY - g.y);
    move(dx / 2, dy / 2);
    zoom(before / Math.max(after, 1));
  } else if (f.pans) {
    move(dx, dy);
  } else {
    rotate(dx, dy);
  }
  f.x = e.clientX; f.y = e.clientY; f.far += Math.abs(dx) + Math.abs(dy);
});
// A press that does not move picks; a mouse that passes over little enough is told what is there.
const MOST_HOVERED = 400000;
let hovered = null;
function hover(x, y) {
  if (facets + triangle_count > MOST_HOVERED) return;
  if (!hovered) requestAnimationFrame(() => {
    const at = pick(...hovered);
    $('tip').hidden = !at;
    if (at) $('tip').textContent = describe(at, ...hovered);
    $('tip').style.transform = 'translate(' + Math.min(hovered[0] + 14, canvas.clientWidth - 250) + 'px,'
      + Math.min(hovered[1] + 14, canvas.clientHeight - 90) + 'px)';
    hovered = null;
  });
  hovered = [x, y];
}
canvas.addEventListener('pointerleave', () => { $('tip').hidden = true; });
const release = e => {
  const f = fingers.get(e.pointerId);
  fingers.delete(e.pointerId);
  if (f && f.far < 4 && e.type === 'pointerup' && !fingers.size) set_picked(pick(...f.from), ...f.from);
};
canvas.addEventListener('pointerup', release);
canvas.addEventListener('pointercancel', release);
canvas.addEventListener('contextmenu', e => e.preventDefault());
canvas.addEventListener('wheel', e => {
  e.preventDefault();
  zoom(Math.exp(Math.max(-1, Math.min(1, e.deltaY * (e.deltaMode ? 0.03 : 0.0015)))),
    e.offsetX - canvas.clientWidth / 2, e.offsetY - canvas.clientHeight / 2);
}, { passive: false });
const nudge = (id, by) => { $(id).value = number(id) + by; change(); };
const next = (id, then) => { $(id).selectedIndex = ($(id).selectedIndex + 1) % $(id).length; then(); };
canvas.addEventListener('keydown', e => {
  const arrow = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[e.key];
  if (e.ctrlKey || e.metaKey || e.altKey) return;
  if (arrow) (e.shiftKey ? move : rotate)(20 * arrow[0], 20 * arrow[1]);
  else if (e.key === '+' || e.key === '=') zoom(0.9);
  else if (e.key === '-') zoom(1 / 0.9);
  else if (e.key === '0') reset();
  else if (e.key === '[' && !flat) nudge('cut', -0.02);
  else if (e.key === ']' && !flat) nudge('cut', 0.02);
  else if (e.key === 'f' && !flat) { $('axis').value = 3; face(frame()[0]); change(); }
  else if (e.key === 'e') nudge('explode', 0.1);
  else if (e.key === 'w') nudge('explode', -0.1);
  else if (e.key === 'd' && count) next('draw', change);
  else if (e.key === 'c') next('colour', () => set_array(arrays[number('colour')]));
  else return;
  e.preventDefault();
});
const on = (id, what, then) => $(id).addEventListener(what, then);
for (const id of ['from', 'to', 'cut', 'explode', 'draw', 'cap', 'plain', 'show']) on(id, 'input', change);
for (const id in from_typed) {
  on(id + '-is', 'change', () => {
    const x = parseFloat($(id + '-is').value);
    if (x === x) {
      $(id).value = from_typed[id](x);
      $(id).dispatchEvent(new Event('input'));
    }
    $(id + '-is').blur();
    look();
  });
}
on('sites', 'input', change);
for (const id of ['outside', 'slivers']) on(id, 'input', () => { set_body(); change(); });
on('projection', 'input', () => { parallel = number('projection') === 1; look(); });
function turn_to(eye) {
  look_along(eye);
  if (!moved) fit();
  look();
}
on('up', 'input', () => {
  set_up_axis(number('up'));
  turn_to(home);
});
document.querySelectorAll('#views button').forEach((b, i) => b.addEventListener('click', () =>
  turn_to([0, 1, 2].map(k => k === i >> 1 ? 1 - 2 * (i & 1) : 0))));
on('go', 'change', () => {
  const id = parseInt($('go').value, 10);
  if (id >= 0) go_to(number('go-kind'), id);
});
on('save', 'click', () => {
  paint();
  canvas.toBlob(blob => {
    const link = document.createElement('a');
    link.href = URL.createObjectURL(blob);
    link.download = document.title.replace(/[^A-Za-z0-9._-]+/g, '-') + '.png';
    link.click();
    URL.revokeObjectURL(link.href);
  });
});

// ---- the link: the address names the view, and brings it back ----

const KEPT = ['up', 'projection', 'show', 'draw', 'axis', 'cap', 'cut', 'relief', 'explode', 'size', 'from', 'to'];
const BOXES = ['outside', 'slivers', 'sites', 'plain'];
function link_text() {
  const numbers = [turn, lift, distance, ...target, ...normal].map(x => +x.toPrecision(6)).join();
  return 'view=' + numbers + '&colour=' + encodeURIComponent(array.name) + KEPT.map(id => '&' + id + '='
    + +number(id).toPrecision(6)).join('') + BOXES.map(id => '&' + id + '=' + +$(id).checked).join('');
}
function follow_link() {
  const given = new URLSearchParams(location.hash.slice(1)), view = (given.get('view') || '').split(',').map(Number);
  if (view.length !== 9 || !view.every(x => Math.abs(x) < 1e9) || !(view[2] > 0)) return;
  const a = arrays.find(x => x.name === given.get('colour'));
  if (a) set_array(a);
  for (const id of KEPT) if (given.has(id)) $(id).value = given.get(id);
  for (const id of BOXES) $(id).checked = given.get(id) === '1';
  for (const id of ['show', 'draw', 'axis', 'up']) if ($(id).selectedIndex < 0) $(id).selectedIndex = 0;
  set_up_axis(number('up') === 3 && !has_up ? 2 : number('up'));
  parallel = number('projection') === 1;
  if (dim === 2) set_relief(number('relief'));
  set_normal(unit(view.slice(6)));
  set_body();
  [turn, lift, distance] = view;
  target = view.slice(3, 6);
  moved = true;
  change();
}
let waiting = 0;                                        // browsers count changes of the address: one after each rest
function keep_link() {
  clearTimeout(waiting);
  waiting = setTimeout(() => { if (moved || location.hash) history.replaceState(null, '', '#' + link_text()); }, 300);
}
for (const what of ['pointerup', 'wheel', 'keyup', 'input', 'change', 'click']) {
  document.addEventListener(what, e => { if (e.target.id !== 'reset' && what !== 'pointerup') moved = moved
    || e.target.id === 'canvas'; keep_link(); });
}
window.addEventListener('hashchange', follow_link);

on('size', 'input', look);
on('relief', 'input', () => { set_relief(number('relief')); change(); });
on('colour', 'input', () => {                           // the colours must be seen
  const a = arrays[number('colour')];
  if (as_model() && !a.of_points && number('cut') >= 1) $('show').value = 0;
  if (number('cut') >= 1) $('plain').checked = false;
  set_array(a);
});
on('axis', 'input', () => {
  face(frame()[0]);
  if (number('cut') >= 1) $('cut').value = 0.5;
  change();
});
on('flip', 'click', () => {
  set_normal(normal.map(x => -x));
  $('cut').value = 1 - number('cut');
  change();
});
on('reset', 'click', reset);
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', look);
new ResizeObserver(() => { if (!moved) fit(); look(); }).observe(canvas);

arrays.forEach((a, i) => $('colour').append(new Option(a.name, i)));
$('go-kind').options[0].textContent = simplex[0];
$('show').options[1].textContent = $('cut-what').textContent = simplex[1];
$('sites').parentNode.hidden = !grouped;
if (!count) document.querySelectorAll('.mesh').forEach(x => { x.hidden = true; });
if (!count || dim === 2) document.querySelectorAll('.solid').forEach(x => { x.hidden = true; });
$('plain').parentNode.hidden = !has_facets;
document.querySelector('.relief').hidden = flat || space === 3;
if (flat) document.querySelectorAll('.cut').forEach(x => { x.hidden = true; });
if (!count && !triangle_count) $('draw').parentNode.hidden = true;
$('show').parentNode.hidden = !triangle_count || !count;
$('outside').parentNode.hidden = !inside;
$('slivers').parentNode.hidden = dim === 2 || !count || kept_only || inside !== null || grouped;
if (flat) document.querySelectorAll('.space').forEach(x => { x.hidden = true; });
document.querySelectorAll('fieldset').forEach(x => {    // menus and buttons stand beside the name of their group
  const row = x.querySelector('.row:not([hidden])');
  if (row && row.matches('div') && !row.querySelector('span')) row.classList.add('first');
});
$('up').options[3].hidden = !has_up;
if (!count) $('go-kind').value = 3;
try {
  if (gl) set_up();
} catch (e) {
  trouble = e.message;
  gl = null;
}
reset();
paint();
follow_link();
say(gl ? '' : 'No picture: ' + trouble + '.  The numbers beside this are right.');
