const move = (dx, dy) => {                              // in pixels of the page
  const [, right, up] = frame(), step = 2 * distance * TAN / Math.max(1, canvas.clientHeight);
  target = target.map((x, k) => x - step * (dx * right[k] - dy * up[k]));
  look();
};
const rotate = (dx, dy) => {
  if (flat) { move(dx, dy); return; }
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
  fingers.set(e.pointerId, { x: e.clientX, y: e.clientY, pans: e.button === 2 || e.shiftKey });
});
canvas.addEventListener('pointermove', e => {
  const f = fingers.get(e.pointerId);
  if (!f) return;
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
  f.x = e.clientX; f.y = e.clientY;
});
const release = e => fingers.delete(e.pointerId);
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
for (const id of ['from', 'to', 'cut', 'explode', 'draw', 'cap', 'plain']) on(id, 'input', change);
on('size', 'input', look);
on('relief', 'input', () => { set_relief(number('relief')); change(); });
on('colour', 'input', () => set_array(arrays[number('colour')]));
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
new ResizeObserver(look).observe(canvas);

arrays.forEach((a, i) => $('colour').append(new Option(a.name, i)));
if (!count) document.querySelectorAll('.mesh').forEach(x => { x.hidden = true; });
if (!count || dim === 2) document.querySelectorAll('.solid').forEach(x => { x.hidden = true; });
document.querySelector('.relief').hidden = flat || dim === 3;
if (flat) document.querySelectorAll('.cut').forEach(x => { x.hidden = true; });
if (!count) $('draw').parentNode.hidden = true;
try {
  if (gl) set_up();
} catch (e) {
  trouble = e.message;
  gl = null;
}
reset();
paint();
say(gl ? '' : 'No picture: ' + trouble + '.  The numbers beside this are right.');
