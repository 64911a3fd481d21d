// The player.  A frame is a script of base64: of each shape a byte with its number of corners, a byte with its
// colour (0: none), and two 16-bit numbers for each corner, 8192 to 57344 across the box.  Shapes of one corner are
// dots, of two are lines, of more are polygons.  film.html#80 begins with frame 80.

const $ = id => document.getElementById(id), given = $('film').dataset;
const frames = [...document.querySelectorAll('script[data-label]')];
const box = given.box.split(' ').map(Number), canvas = $('canvas'), context = canvas.getContext('2d');
let at = Math.max(0, Math.min(location.hash.slice(1) - 1 || 0, frames.length - 1)), playing = false, last = 0;
$('title').textContent = document.title;
$('note').textContent = given.note;
$('frame').max = frames.length - 1;
window.onerror = text => { $('label').textContent = 'This page failed: ' + text; };

const stops = [[49, 54, 149], [69, 117, 180], [171, 217, 233], [255, 255, 191], [253, 174, 97], [215, 48, 39],
  [165, 0, 38]];
const colours = Array.from({ length: 256 }, (_, i) => {
  const x = Math.max(i - 1, 0) / 254 * (stops.length - 1), k = Math.min(Math.floor(x), stops.length - 2);
  return 'rgb(' + stops[k].map((c, j) => Math.round(c + (x - k) * (stops[k + 1][j] - c))) + ')';
});

function legend() {
  const scale = $('scale').getContext('2d');
  for (let i = 0; i < 256; i++) {
    scale.fillStyle = colours[Math.max(i, 1)];
    scale.fillRect(i, 0, 1, 1);
  }
  $('least').textContent = given.least;
  $('most').textContent = given.most;
  $('name').textContent = given.name;
  $('legend').hidden = !given.name;
}

// The shapes of a frame as one path for each colour.
function paths_of(frame) {
  const text = atob(frame.textContent.replace(/\s/g, '')), fill = new Map(), line = new Map(), dot = new Map();
  const width = canvas.width, height = canvas.height, size = Math.max(1.5, width / 600);
  const number = i => text.charCodeAt(i) | text.charCodeAt(i + 1) << 8;
  for (let i = 0; i < text.length;) {
    const corners = text.charCodeAt(i), colour = text.charCodeAt(i + 1);
    const group = corners === 1 ? dot : corners === 2 ? line : fill;
    if (!group.has(colour)) group.set(colour, new Path2D());
    const path = group.get(colour);
    i += 2;
    for (let k = 0; k < corners; k++, i += 4) {
      const x = (number(i) - 8192) / 49152 * width, y = height - (number(i + 2) - 8192) / 49152 * height;
      if (corners === 1) path.rect(x - size / 2, y - size / 2, size, size);
      else if (k === 0) path.moveTo(x, y);
      else path.lineTo(x, y);
    }
    if (corners > 2) path.closePath();
  }
  return { fill, line, dot };
}

function paint() {
  const style = getComputedStyle(document.documentElement), ink = style.getPropertyValue('--ink');
  canvas.style.width = '';                       // all of the page's
  const wide = canvas.clientWidth, ratio = window.devicePixelRatio || 1, room = window.innerHeight - 190;
  const scale = Math.min(wide / (box[2] - box[0]), Math.max(room, 240) / (box[3] - box[1]));
  canvas.width = Math.round((box[2] - box[0]) * scale * ratio);
  canvas.height = Math.round((box[3] - box[1]) * scale * ratio);
  canvas.style.height = canvas.height / ratio + 2 + 'px';                 // and a border
  canvas.style.width = canvas.width / ratio + 2 + 'px';
  $('number').value = frames.length ? at + 1 + ' of ' + frames.length : 'no frames';
  if (!frames.length) return;
  $('frame').value = at;
  $('label').textContent = frames[at].dataset.label;
  const { fill, line, dot } = paths_of(frames[at]);
  context.lineWidth = ratio * 0.75;
  for (const [colour, path] of fill) {
    context.fillStyle = colour ? colours[colour] : '#8884';
    context.fill(path);
    if (!$('edges').checked && colour) {         // closes the seams between neighbours
      context.strokeStyle = colours[colour];
      context.stroke(path);
    }
  }
  if ($('edges').checked) {
    context.strokeStyle = style.getPropertyValue('--line');
    for (const path of fill.values()) context.stroke(path);
  }
  for (const [colour, path] of dot) {
    context.fillStyle = colour ? colours[colour] : ink;
    context.fill(path);
  }
  context.lineWidth = 2 * ratio;
  for (const [colour, path] of line) {
    context.strokeStyle = colour ? colours[colour] : ink;
    context.stroke(path);
  }
}

function go(frame) {
  at = Math.min(Math.max(frame, 0), frames.length - 1);
  paint();
}

function tick(now) {
  if (!playing) return;
  if (now - last >= 1000 / $('speed').value) {
    last = now;
    go(at + 1 < frames.length ? at + 1 : 0);
  }
  requestAnimationFrame(tick);
}

function play(on) {
  playing = on && frames.length > 1;
  $('play').textContent = playing ? 'Pause' : 'Play';
  if (playing) requestAnimationFrame(tick);
}

function step(by) {
  play(false);
  go(at + by);
}

$('play').onclick = () => play(!playing);
$('back').onclick = () => step(-1);
$('on').onclick = () => step(1);
$('frame').oninput = () => { play(false); go(+$('frame').value); };
$('edges').onchange = paint;
window.onresize = paint;
window.onkeydown = event => {
  if (event.target.tagName === 'SELECT') return;
  if (event.key === ' ' && event.target.tagName !== 'BUTTON') { event.preventDefault(); play(!playing); }
  if (event.target.id === 'frame') return;
  if (event.key === 'ArrowLeft') step(-1);
  if (event.key === 'ArrowRight') step(1);
};
legend();
paint();
