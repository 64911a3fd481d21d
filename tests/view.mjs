// view.mjs BROWSER FOLDER: opens the pages that tests/view.sh made and uses them as people do, by the DevTools
// protocol over a pipe; looks at what is on the screen.  WebGL 2 comes from the browser's software renderer.
import { spawn } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, readdirSync, rmSync } from 'node:fs';
import { inflateSync } from 'node:zlib';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';

const [browser, folder] = process.argv.slice(2);
let passed = 0, failed = 0;
function check(name, fine, detail = '') {
  if (fine) { passed++; return; }
  failed++;
  console.log('FAILED ' + name + ' ' + detail);
}
function finish() {
  console.log(passed + ' passed, ' + failed + ' failed, 0 skipped');
  process.exit(failed > 0 ? 1 : 0);
}
const pause = ms => new Promise(done => setTimeout(done, ms));

// ---- the browser ----

const profile = mkdtempSync(join(tmpdir(), 'pbw-view-'));
const chromium = spawn(browser, ['--headless=new', '--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader',
  '--enable-unsafe-swiftshader', '--disable-quic', '--no-first-run', '--disable-background-networking',
  '--disable-component-update', '--disable-sync', '--disable-extensions', '--disable-dev-shm-usage',
  '--hide-scrollbars', '--user-data-dir=' + profile, '--remote-debugging-pipe', 'about:blank'],
  { stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe'] });
let text = '', last = 0;
const answers = new Map(), events = [];
chromium.stdio[4].on('data', data => {
  text += data;
  for (let end; (end = text.indexOf('\0')) >= 0; text = text.slice(end + 1)) {
    const message = JSON.parse(text.slice(0, end));
    if (message.id) answers.get(message.id)(message); else events.push(message);
  }
});
function send(method, params = {}, sessionId = undefined) {
  return new Promise(done => {
    answers.set(++last, message => {
      if (message.error) console.log(method + ': ' + message.error.message);
      done(message.result || {});
    });
    chromium.stdio[3].write(JSON.stringify({ id: last, method, params, sessionId }) + '\0');
  });
}
let session;
const tell = (method, params) => send(method, params, session);
async function stop() {
  chromium.removeAllListeners('exit');
  const gone = new Promise(done => chromium.on('exit', done));
  chromium.kill('SIGKILL');
  await gone;
  try { rmSync(profile, { recursive: true, force: true, maxRetries: 5 }); } catch { /* /tmp is swept */ }
  finish();
}
chromium.on('error', e => { check('the browser starts', false, e.message); finish(); });
chromium.on('exit', code => { check('the browser lives', false, 'exit status ' + code); finish(); });
// Waits for a state, as long as it takes on a loaded machine; run.sh has the limit for a browser that hangs.
async function until(name, holds) {
  for (let i = 0; i < 3000; i++) {
    if (await holds()) { check(name, true); return; }
    await pause(100);
  }
  check(name, false);
}

async function evaluate(expression) {
  const answer = await tell('Runtime.evaluate', { expression, awaitPromise: true, returnByValue: true });
  if (answer.exceptionDetails) console.log(expression + ': ' + JSON.stringify(answer.exceptionDetails).slice(0, 500));
  return answer.result && answer.result.value;
}
const painted = () => evaluate('new Promise(f => requestAnimationFrame(() => requestAnimationFrame(f)))');
const get = (id, what = 'textContent') => evaluate('document.getElementById("' + id + '").' + what);
async function set(id, value) {
  await evaluate('{ const e = document.getElementById("' + id + '"); e.value = ' + JSON.stringify(value) + ';'
    + 'e.dispatchEvent(new Event("input")); }');
  await painted();
}
async function click(id) {
  await evaluate('document.getElementById("' + id + '").click()');
  await painted();
}
const colour_by = name => evaluate('[...document.getElementById("colour").options].find(o => o.text === "' + name
  + '").value').then(value => set('colour', value));

// The page in a window; returns the seconds until it is drawn.
async function open(name, { width = 1000, height = 640, scheme = 'light', hash = '' } = {}) {
  events.length = 0;
  await tell('Emulation.setDeviceMetricsOverride', { width, height, deviceScaleFactor: 1, mobile: false });
  await tell('Emulation.setEmulatedMedia', { features: [{ name: 'prefers-color-scheme', value: scheme }] });
  const start = Date.now();
  await tell('Page.navigate', { url: 'file://' + resolve(folder, name + '.html') + hash });
  while (!events.some(e => e.method === 'Page.loadEventFired')) await pause(10);
  await painted();
  return (Date.now() - start) / 1000;
}
function check_quiet(name) {
  const bad = events.filter(e => /exceptionThrown|entryAdded|consoleAPICalled/.test(e.method));
  check(name + ': the console is empty', bad.length === 0, JSON.stringify(bad).slice(0, 500));
  const asked = events.filter(e => e.method === 'Network.requestWillBeSent').map(e => e.params.request.url);
  check(name + ': nothing else is loaded', asked.every(url => /^(file|data):/.test(url)), asked.join(' '));
}

// ---- pixels ----

// A PNG picture of 8 bits: width, height, and 3 bytes a pixel (PNG specification, sections 7 and 9).
function decode(png) {
  const width = png.readUInt32BE(16), height = png.readUInt32BE(20), each = png[25] === 6 ? 4 : 3, parts = [];
  for (let at = 8; at < png.length; at += 12 + png.readUInt32BE(at)) {
    const type = png.toString('latin1', at + 4, at + 8);
    if (type === 'IDAT') parts.push(png.subarray(at + 8, at + 8 + png.readUInt32BE(at)));
  }
  const raw = inflateSync(Buffer.concat(parts)), row = width * each, out = new Uint8Array(height * row);
  for (let y = 0; y < height; y++) {
    const filter = raw[y * (row + 1)];
    for (let x = 0; x < row; x++) {
      const i = y * row + x, a = x < each ? 0 : out[i - each], b = y === 0 ? 0 : out[i - row];
      const c = x < each || y === 0 ? 0 : out[i - row - each], p = a + b - c;
      const pa = Math.abs(p - a), pb = Math.abs(p - b), pc = Math.abs(p - c);
      const guess = [0, a, b, (a + b) >> 1, pa <= pb && pa <= pc ? a : pb <= pc ? b : c][filter];
      out[i] = raw[y * (row + 1) + 1 + x] + guess;
    }
  }
  const rgb = new Uint8Array(3 * width * height);
  for (let i = 0; i < width * height; i++) for (let k = 0; k < 3; k++) rgb[3 * i + k] = out[each * i + k];
  return { width, height, rgb };
}
async function picture_of(id) {
  const box = JSON.parse(await evaluate('JSON.stringify(document.getElementById("' + id
    + '").getBoundingClientRect())'));
  const clip = { x: box.x, y: box.y, width: box.width, height: box.height, scale: 1 };
  return decode(Buffer.from((await tell('Page.captureScreenshot', { format: 'png', clip })).data, 'base64'));
}
// What the canvas shows, without the axes in its corner.
async function picture() {
  const image = await picture_of('stage');
  for (let y = image.height - 100; y < image.height; y++) {
    for (let x = 0; x < 100; x++) image.rgb.set(image.rgb.subarray(12, 15), 3 * (y * image.width + x));
  }
  return image;
}
const count = (image, fits) => {
  let found = 0;
  for (let i = 0; i < image.rgb.length; i += 3) found += fits(image.rgb[i], image.rgb[i + 1], image.rgb[i + 2]);
  return found / (image.rgb.length / 3);
};
const near = (...c) => (...d) => c.every((x, k) => Math.abs(x - d[k]) <= 3);
const PAPER = near(247, 248, 250), DARK = near(18, 22, 28);
const covered = image => 1 - count(image, PAPER);
const differ = (a, b) => {
  let found = 0;
  for (let i = 0; i < a.rgb.length; i += 3) {
    found += Math.abs(a.rgb[i] - b.rgb[i]) + Math.abs(a.rgb[i + 1] - b.rgb[i + 1])
      + Math.abs(a.rgb[i + 2] - b.rgb[i + 2]) > 24;
  }
  return found / (a.rgb.length / 3);
};
// How many of the colours of classes are seen, shaded or not: in the same ratios.
const hues = image => [[0, 114, 178], [230, 159, 0], [0, 158, 115], [204, 121, 167], [86, 180, 233], [213, 94, 0],
  [240, 228, 66]].filter(c => count(image, (...d) => {
  const s = (d[0] + d[1] + d[2]) / (c[0] + c[1] + c[2]);
  return s > 0.3 && c.every((x, k) => Math.abs(x * s - d[k]) < 7);
}) > 0.005).length;
const between = (x, low, high) => x >= low && x <= high;
const shown = async () => +(await get('shown')).split(' ')[0].replaceAll(',', '');

// ---- the pages ----

async function test_square() {
  await open('square');
  await set('draw', 1);
  const image = await picture();
  const blue = count(image, near(0, 114, 178)), orange = count(image, near(230, 159, 0));
  check('square: two triangles in the colours of their parts, as large',
    blue > 0.1 && Math.abs(blue - orange) < 0.02, blue + ' ' + orange);
  check('square: nothing else', Math.abs(covered(image) - blue - orange) < 0.01, '' + covered(image));
  await set('draw', 2);
  check('square: edges are less than faces', between(covered(await picture()), 0.002, 0.05));
  await set('draw', 1);
  await set('explode', 1);
  const two = await picture(), apart = covered(two) / covered(image);
  const middle = 3 * ((two.height >> 1) * two.width + (two.width >> 1));
  check('square: half as large, a quarter of the area', Math.abs(apart - 0.25) < 0.02, '' + apart);
  check('square: with a gap between them', PAPER(...two.rgb.subarray(middle, middle + 3)));
  check('square: no cut, no projection in the plane', await evaluate('document.querySelector(".cut").hidden')
    && await get('projection', 'parentNode.hidden') && await get('plain', 'parentNode.hidden'));
  await set('explode', 0);
  await type_in('explode-is', '100 %');
  check('square: explode, typed', differ(two, await picture()) < 0.001
    && await get('explode-is', 'value') === '100 %');
  check_quiet('square');
}

// Corners at 0 and at 4 on each axis; seen along (1,1,1), a tip cut off at x = 2 uncovers a sixth of the picture, up
// to perspective.
async function test_corner() {
  await open('corner');
  await set('draw', 1);
  const cut = await picture();
  await set('cut', 1);
  const whole = await picture(), left = covered(cut) / covered(whole);
  check('corner: cut through the middle', between(left, 0.78, 0.88) && between(covered(whole), 0.1, 0.9), '' + left);
  await set('cut', 0.5);
  await set('cap', 0);
  check('corner: a tetrahedron with its centre on this side stays whole', await shown() === 1
    && differ(await picture(), whole) < 0.01);
  await set('cut', 0.2);
  check('corner: and else goes', await shown() === 0 && covered(await picture()) < 0.001);
  await click('flip');
  check('corner: the other side', await shown() === 1);
  check_quiet('corner');
}

async function key(name, code, modifiers = 0) {
  const printed = name.length === 1 ? { text: name } : {};
  await tell('Input.dispatchKeyEvent', { type: 'keyDown', key: name, code, modifiers, ...printed });
  await tell('Input.dispatchKeyEvent', { type: 'keyUp', key: name, code, modifiers });
  await painted();
}
async function drag(button, dx, dy) {
  const at = { x: 300, y: 300, button, clickCount: 1 };
  await tell('Input.dispatchMouseEvent', { ...at, type: 'mousePressed' });
  await tell('Input.dispatchMouseEvent', { ...at, type: 'mouseMoved', x: 300 + dx, y: 300 + dy });
  await tell('Input.dispatchMouseEvent', { ...at, type: 'mouseReleased', x: 300 + dx, y: 300 + dy });
  await painted();
}

async function test_solid() {
  const qualities = readFileSync(join(folder, 'quality.txt'), 'latin1').trim().split('\n').map(Number);
  await open('solid');
  const title = '</title><script>hacked=1</script>\'"&<b> ü';
  check('solid: a hostile title is text', await evaluate('document.title') === title && await get('title') === title
    && await evaluate('typeof hacked') === 'undefined'
    && await evaluate('document.querySelectorAll("b").length') === 0);
  check('solid: counts', (await get('facts')).startsWith(qualities.length.toLocaleString('en-US')
    + ' tetrahedra, 3,000 points in 3D'), await get('facts'));
  const first = await picture(), cut_shown = await shown();
  check('solid: something is drawn', between(covered(first), 0.15, 0.9), '' + covered(first));
  check('solid: cut open, in many colours', new Set(first.rgb.filter((_, i) => i % 3 === 0)).size > 100
    && count(first, (r, g, b) => r > b + 60) > 0.05);
  await set('cut', 0.3);
  const deeper = await picture();
  check('solid: the clip slider changes pixels', differ(first, deeper) > 0.05, '' + differ(first, deeper));
  check('solid: and shows less', await shown() < cut_shown && await shown() > 0);
  await set('cap', 1);
  check('solid: cut through', differ(deeper, await picture()) > 0.02);
  await set('cap', 0);
  await set('cut', 1);
  const without = await shown();
  check('solid: slivers at the hull are hidden', between(without, 0.9 * qualities.length, qualities.length - 1)
    && qualities.length - without <= qualities.filter(x => x <= 0.05).length);
  await click('slivers');
  check('solid: no cut shows all', await shown() === qualities.length);
  await set('to', 0.5);                                              // halfway from 0 to 1
  const low = qualities.filter(x => x <= 0.5).length;
  check('solid: those of quality up to 0.5', Math.abs(await shown() - low) <= 2, await shown() + ' ' + low);
  check('solid: quality as in the .vtu file', Math.abs(parseFloat((await get('summary')).match(/mean ([0-9.]*)/)[1])
    - qualities.reduce((a, b) => a + b) / qualities.length) < 0.006, await get('summary'));
  check('solid: the histogram tells in words', (await get('chart', 'getAttribute("aria-label")')).startsWith(
    'Histogram of quality: least '));
  check('solid: the definition', (await get('about')).startsWith('Mean ratio: '));
  await click('reset');
  check('solid: reset', differ(first, await picture()) < 0.001);
  await set('explode', 0.6);
  check('solid: exploded', differ(first, await picture()) > 0.1);
  await click('reset');

  await colour_by('part');
  await click('plain');
  const seen = hues(await picture());
  check('solid: parts in colours that tell them apart', seen >= 4, '' + seen);
  check('solid: a legend of eight parts', await evaluate('document.getElementById("classes").children.length') === 8);
  await click('plain');
  await click('reset');
  await colour_by('quality');

  await evaluate('document.getElementById("canvas").focus()');
  await key('0', 'Digit0');
  const focused = await picture();
  check('solid: the focus is seen', between(differ(first, focused), 0.0005, 0.02));
  for (const [name, code] of [['ArrowLeft', 'ArrowLeft'], ['ArrowUp', 'ArrowUp'], ['+', 'Equal'], ['-', 'Minus'],
    ['[', 'BracketLeft'], ['f', 'KeyF'], ['e', 'KeyE'], ['d', 'KeyD'], ['c', 'KeyC']]) {
    await key(name, code);
    check('solid: key ' + name, differ(focused, await picture()) > 0.01);
    await colour_by('quality');
    await key('0', 'Digit0');
    check('solid: key 0 after ' + name, differ(focused, await picture()) < 0.001);
  }
  await key('ArrowLeft', 'ArrowLeft', 8);
  check('solid: shift and an arrow move', differ(focused, await picture()) > 0.01);
  await key('0', 'Digit0');
  await drag('left', 90, 40);
  check('solid: the mouse turns', differ(first, await picture()) > 0.05);
  await click('reset');
  await drag('right', 90, 40);
  check('solid: the right button moves', differ(first, await picture()) > 0.05
    && Math.abs(covered(await picture()) - covered(first)) < 0.02);
  await click('reset');
  await tell('Input.dispatchMouseEvent', { type: 'mouseWheel', x: 350, y: 320, deltaX: 0, deltaY: 400 });
  await until('solid: the wheel zooms', async () => covered(await picture()) < 0.6 * covered(first));
  await click('reset');
  const fingers = d => [{ x: 300 - d, y: 300, id: 1 }, { x: 300 + d, y: 300, id: 2 }];
  await tell('Input.dispatchTouchEvent', { type: 'touchStart', touchPoints: fingers(100) });
  await tell('Input.dispatchTouchEvent', { type: 'touchMove', touchPoints: fingers(50) });
  await tell('Input.dispatchTouchEvent', { type: 'touchEnd', touchPoints: [] });
  await painted();
  check('solid: two fingers zoom', between(covered(await picture()) / covered(first), 0.1, 0.6));
  await click('reset');

  check('solid: each control has a name', await evaluate(`[...document.querySelectorAll('input, select, button')]
    .every(e => e.tagName === 'BUTTON' && e.textContent.trim() || e.labels.length || e.getAttribute('aria-label'))`));
  check('solid: the picture has a text', (await get('canvas', 'getAttribute("aria-label")'))
    .includes('tetrahedra shown'));
  check_quiet('solid');
  await open('solid', { scheme: 'dark' });
  check('solid: dark', count(await picture(), DARK) > 0.2 && count(await picture(), PAPER) < 0.001);
  await open('solid', { width: 380, height: 700 });
  check('solid: on a telephone', between(covered(await picture()), 0.1, 0.9)
    && await evaluate('document.documentElement.scrollWidth <= 380'));
  check_quiet('solid, small and dark');
}

async function test_flat() {
  await open('flat');
  const image = await picture();
  check('flat: drawn', between(covered(image), 0.1, 0.9));
  await drag('left', 90, 40);
  check('flat: the mouse moves', differ(image, await picture()) > 0.01);
  await click('reset');
  await colour_by('order');
  check('flat: colours of points', differ(image, await picture()) > 0.05);
  check_quiet('flat');
}

// Which threads insert what is another matter each time, but all do.
async function test_threads() {
  await open('threads');
  const image = await picture(), seen = hues(image);
  check('threads: a legend of eight', await evaluate('document.getElementById("classes").children.length') === 8,
    await get('summary'));
  check('threads: in colours that tell them apart', seen >= 4, '' + seen);
  await colour_by('round');
  const [, low, high] = (await get('summary')).match(/least ([0-9]+).*largest ([0-9]+)/) || [];
  check('threads: rounds on a scale of more than two', high - low >= 2, await get('summary'));
  check('threads: and no classes', await evaluate('document.getElementById("classes").children.length') === 0);
  check('threads: in other colours', differ(image, await picture()) > 0.2);
  check_quiet('threads');
}

async function test_terrain() {
  await open('terrain');
  const image = await picture();
  check('terrain: drawn in all colours of the scale', between(covered(image), 0.15, 0.9)
    && count(image, (r, g, b) => r > 200 && g > 150 && b < 110) > 0.001
    && count(image, (r, g, b) => b > r + 20) > 0.02);
  check('terrain: as high as it is', (await get('summary')).endsWith('largest 34'), await get('summary'));
  await set('relief', 8);
  const steep = await picture();
  check('terrain: steeper', differ(image, steep) > 0.1);
  await set('relief', 2);
  await type_in('relief-is', 8);
  check('terrain: heights, typed', differ(steep, await picture()) < 0.001
    && await get('relief-is', 'value') === 'times 8');
  await click('reset');
  check('terrain: reset', differ(image, await picture()) < 0.001);
  await set('cut', 0.5);
  check('terrain: cut', between(await shown(), 30000, 45000) && (await get('cut-is', 'value')).startsWith('1'));
  check_quiet('terrain');
}

async function test_points() {
  await open('points');
  const image = await picture();
  check('points: drawn', between(covered(image), 0.05, 0.9) && await shown() === 5000);
  check('points: coloured by height', await get('colour', 'selectedOptions[0].text') === 'z');
  await set('size', 3);
  const larger = await picture();
  check('points: larger', covered(larger) > 1.2 * covered(image));
  await set('size', 1);
  await type_in('size-is', 3);
  check('points: size, typed', differ(larger, await picture()) < 0.001 && await get('size-is', 'value') === '3');
  await set('cut', 0.5);
  check('points: half of them', between(await shown(), 2300, 2700));
  check_quiet('points');
}

async function test_million() {
  const seconds = await open('million');
  const image = await picture();
  check('million: drawn', between(covered(image), 0.15, 0.9));
  const wait = [];
  for (const place of [0.4, 0.45, 0.55, 0.6]) {
    const start = Date.now();
    await set('cut', place);
    wait.push(Date.now() - start);
  }
  check('million: changes pixels', differ(image, await picture()) > 0.05);
  await set('explode', 0.5);
  check('million: exploded', differ(image, await picture()) > 0.1);
  check_quiet('million');
  console.log((await get('facts')) + ': ' + seconds + ' s to load, ' + wait.join(' ') + ' ms to move the cut');
}

// All that one's own model meets at first: a body that stands on a base across y.
async function test_model() {
  await open('pawn');
  const first = await picture();
  check('model: y is up, as it stands', await get('up', 'value') === '1');
  check('model: its own faces, uncut', (await get('shown')) === '336 faces of the model shown'
    && (await get('cut-is', 'value')) === 'no cut');
  check('model: plain and drawn', between(covered(first), 0.1, 0.6) && count(first, (r, g, b) => r > b + 20) === 0);
  await set('up', 2);
  check('model: z up on demand', differ(first, await picture()) > 0.1);
  await click('reset');
  check('model: reset', differ(first, await picture()) < 0.001);
  await set('cut', 0.5);
  check('model: cut open, in colours', count(await picture(), (r, g, b) => Math.abs(r - b) > 60) > 0.005);
  await set('cut', 1);
  await set('show', 0);
  const inner = await shown();
  await click('outside');
  check('model: tetrahedra inside, and all', inner > 100 && await shown() > 1.1 * inner);
  await click('reset');
  check_quiet('model');
}

// A disc across y: it is plain at first, as its points have no value but their order, and not cut across its plane.
async function test_flat_model() {
  await open('disc');
  const flat = await picture(), coloured = image => count(image, (r, g, b) => Math.abs(r - b) > 60);
  check('flat model: shown', (await get('shown')) === '60 faces of the model shown' && covered(flat) > 0.05,
    await get('shown') + covered(flat));
  check('flat model: plain', coloured(flat) === 0);
  check('flat model: no cut, and none across y', await get('cut-is', 'value') === 'no cut'
    && await get('axis', 'value') !== '1');
  await set('cut', 0.5);
  check('flat model: half of it', between(covered(await picture()) / covered(flat), 0.3, 0.7));
  await set('cut', 1);
  await click('plain');
  check('flat model: colours', coloured(await picture()) > 0.02);
  check('flat model: its group has its menu beside its name', await evaluate(`(() => {
    const menu = document.getElementById('draw'), name = menu.closest('fieldset').querySelector('legend');
    return Math.abs(menu.getBoundingClientRect().top - name.getBoundingClientRect().top) < 8; })()`));
  await set('draw', 4);
  check('flat model: its points', await shown() === 61);
  check_quiet('flat model');
}

// A surface is shown as it is, its triangles measured in space.
async function test_surface() {
  await open('tower');
  check('surface: its triangles', await shown() === 336 && (await get('facts')).includes('336 triangles')
    && (await get('facts')).endsWith('in 3D'), await get('facts'));
  check('surface: no heights to stretch', await evaluate('document.querySelector(".relief").hidden'));
  const all = covered(await picture());
  await set('axis', 2);
  await set('cut', 0.5);
  check('surface: cut', covered(await picture()) < 0.8 * all && await shown() < 336);
  await set('cut', 1);
  await colour_by('area');
  const area = +readFileSync(join(folder, 'tower.txt'), 'utf8').match(/area ([0-9.]+)/)[1];
  const mean = +(await get('summary')).match(/mean ([0-9.]+)/)[1];
  check('surface: areas in space', Math.abs(336 * mean / area - 1) < 0.01, mean + ' ' + area);
  check_quiet('surface');
}

// Sites are drawn over the cells of the plane on demand; labels name what is shown.
async function test_sites() {
  await open('cells2');
  check('sites: labels of cells', await evaluate('document.getElementById("go-kind").options[0].text') === 'cell');
  check('sites: the scale bar lies beside the picture', await evaluate(`document.getElementById('bar')
    .getBoundingClientRect().left >= document.getElementById('canvas').getBoundingClientRect().right`));
  const dark = (r, g, b) => r + g + b < 120, before = count(await picture(), dark);
  await click('sites');
  check('sites: drawn', count(await picture(), dark) > before + 0.002);
  await set('draw', 4);
  check('sites: alone as points', await shown() === 200, await get('shown'));
  check_quiet('sites');
}

// Regions and patches are told by their names; facets in no patch are plain.
async function test_named() {
  const legend = () => evaluate('[...document.getElementById("classes").children].map(x => x.textContent).join()');
  await open('named');
  check('named: regions first, outside too', await get('colour', 'selectedOptions[0].text') === 'region'
    && await legend() === 'air,<water>' && !await get('plain', 'checked'), await legend());
  check('named: in the colour of its name', count(await picture(), (r, g, b) => r > g + 60) > 0.1);
  await colour_by('patch');
  check('named: patches', await legend() === 'inlet,wall' && (await get('summary')) === '2 names', await legend());
  await set('go', 0);
  await evaluate('document.getElementById("go").dispatchEvent(new Event("change"))');
  await painted();
  check('named: a simplex by names', /region air; patch (inlet, wall|wall, inlet)/.test(await get('picked')),
    await get('picked'));
  check_quiet('named');
}

// Which way up a page shows what is y up, z up, ground.
async function test_up() {
  const up = () => evaluate(`(() => { const line = document.querySelectorAll('#axes line'), text =
    document.querySelectorAll('#axes text'); return [...text].map((t, i) => [line[i].getAttribute('y2') / 25,
    t.textContent]).sort((a, b) => a[0] - b[0])[0][1]; })()`);
  for (const [name, axis, letter] of [['pawn', '1', 'y'], ['tower', '2', 'z'], ['ground', '1', 'y']]) {
    await open(name);
    check('up: ' + name, await get('up', 'value') === axis && await up() === letter, await get('up', 'value'));
    const first = await picture();
    await set('up', axis === '1' ? 2 : 1);
    check('up: ' + name + ', the other', await up() === (axis === '1' ? 'z' : 'y')
      && differ(first, await picture()) > 0.02);
    await set('up', axis);
    check('up: ' + name + ', and back', differ(first, await picture()) < 0.001);
    check_quiet('up: ' + name);
  }
}

// With --inside, a page has what is inside, all of it: slivers are part of the answer.
async function test_inside() {
  await open('inside');
  const all = +(await get('facts')).split(' ')[0].replaceAll(',', '');
  check('inside: no outside, no slivers to hide', await get('slivers', 'parentNode.hidden')
    && await get('outside', 'parentNode.hidden'));
  await set('show', 0);
  check('inside: all is shown', all > 100 && await shown() === all, await get('shown'));
  await set('to', 0.05);
  check('inside: slivers, too', between(await shown(), 1, all - 1), await get('shown'));
  check_quiet('inside');
}

async function test_views() {
  await open('solid');
  const first = await picture();
  await open('solid', { width: 800, height: 700 });
  const fitted = await picture();
  await open('solid');
  await tell('Emulation.setDeviceMetricsOverride', { width: 800, height: 700, deviceScaleFactor: 1, mobile: false });
  await until('views: a resize fits', async () => differ(fitted, await picture()) < 0.005);
  const distance = async () => +(await evaluate('location.hash')).slice(6).split(',')[2];
  await evaluate('document.getElementById("canvas").focus()');
  await key('+', 'Equal');
  await until('views: the address keeps what was moved', async () => await distance() > 0);
  const near = await distance();
  await tell('Emulation.setDeviceMetricsOverride', { width: 600, height: 700, deviceScaleFactor: 1, mobile: false });
  await painted();
  await key('ArrowLeft', 'ArrowLeft');
  const before = await evaluate('location.hash');
  await until('views: another address after a turn', async () => await evaluate('location.hash') !== before
    || await evaluate('location.hash.split(",")[0]') !== before.split(',')[0]);
  check('views: not fitted again once moved', Math.abs(await distance() - near) < 1e-5);
  await open('solid');
  await set('projection', 1);
  const parallel = await picture();
  check('views: parallel', between(differ(first, parallel), 0.02, 0.9) && between(covered(parallel), 0.15, 0.9));
  await evaluate('document.querySelectorAll("#views button")[4].click()');
  await painted();
  check('views: from z', differ(parallel, await picture()) > 0.05
    && await evaluate('document.querySelectorAll("#axes text").length') === 3);
  const length = async () => [parseFloat(await get('bar')), parseFloat(await get('bar', 'style.width'))];
  const [a, b] = await length();
  check('views: a scale bar of a round length', /^[125]0*$/.test((await get('bar')).replace(/^0\.0*/, ''))
    && between(b, 40, 141), a + ' ' + b);
  await evaluate('document.getElementById("canvas").focus()');
  for (let i = 0; i < 8; i++) await key('+', 'Equal');
  const [c, d] = await length();
  check('views: the bar follows', Math.abs((d / c) / (b / a) * 0.9 ** 8 - 1) < 0.01, [a, b, c, d].join());
  check_quiet('views');
}

async function press(x, y) {
  const at = { x, y, button: 'left', clickCount: 1 };
  await tell('Input.dispatchMouseEvent', { ...at, type: 'mousePressed' });
  await tell('Input.dispatchMouseEvent', { ...at, type: 'mouseReleased' });
  await painted();
}
async function type_in(id, value) {
  await evaluate('{ const e = document.getElementById("' + id + '"); e.value = "' + value
    + '"; e.dispatchEvent(new Event("change")); }');
  await painted();
}

async function test_picking() {
  await open('square');                                 // 0,0 1,0 0,1 1,1
  const box = JSON.parse(await evaluate('JSON.stringify(document.getElementById("stage").getBoundingClientRect())'));
  const bar = parseFloat(await get('bar', 'style.width')) / parseFloat(await get('bar'));     // pixels a unit
  const x = box.width / 2 - 0.45 * bar, y = box.height / 2 + 0.45 * bar;                      // beside 0,0
  await press(x, y);
  const told = await get('picked');
  check('picking: a triangle, its corner and quality', /^triangle [01]; points/.test(told)
    && told.includes('nearest: point 0 (0, 0)') && told.includes('quality 0.866'), told);
  check('picking: marked', await evaluate('document.querySelectorAll("#mark line").length') === 3);
  await tell('Input.dispatchMouseEvent', { type: 'mouseMoved', x: x + 0.9 * bar, y: y - 0.9 * bar });
  await until('picking: hovering tells', async () => !(await get('tip', 'hidden'))
    && (await get('tip')).includes('nearest: point 3 (1, 1)'));
  await press(5, 5);
  check('picking: nothing there', await get('picked') === '');
  await set('go-kind', 3);
  await type_in('go', 2);
  check('picking: to a point', (await get('picked')).startsWith('point 2 (0, 1)'), await get('picked'));
  check('picking: in the middle', await evaluate(`(() => { const c = document.querySelector('#mark circle'),
    s = document.getElementById('stage'); return Math.hypot(c.getAttribute('cx') - s.clientWidth / 2,
    c.getAttribute('cy') - s.clientHeight / 2) < 1; })()`));
  await type_in('go', 99);
  check('picking: no such id', (await get('picked')).startsWith('None'));
  await open('solid');
  await type_in('cut-is', 0.25);
  check('typed: the cut', (await get('cut-is', 'value')) === '0.25', await get('cut-is', 'value'));
  await type_in('to-is', 0.5);
  check('typed: a limit', (await get('to', 'value')) === '0.5');
  await press(300, 320);
  check('picking: a tetrahedron', /^tetrahedron \d+; points (\d+, ){3}\d+; quality/.test(await get('picked')),
    await get('picked'));
  check_quiet('picking');
}

// Measures of the corner (0,0,0) (4,0,0) (0,4,0) (0,0,4) from its geometry.
async function test_measures() {
  await open('corner');
  await set('cut', 1);
  const s = Math.sqrt(3), radius = 4 / (3 + s);
  for (const [name, value] of [['least dihedral angle', 180 / Math.PI * Math.acos(1 / s)],
    ['largest dihedral angle', 90], ['aspect ratio', 4 * Math.SQRT2 / (2 * Math.sqrt(6) * radius)],
    ['volume', 64 / 6], ['shortest edge', 4], ['longest edge', 4 * Math.SQRT2]]) {
    await colour_by(name);
    const found = +(await get('summary')).match(/mean ([0-9.]*[0-9])/)[1];
    check('measures: ' + name, Math.abs(found / value - 1) < 0.01, found + ' ' + value);
    check('measures: ' + name + ' is defined', (await get('about')).length > 5);
  }
  check_quiet('measures');
}

async function test_links_and_files() {
  await open('solid');
  const first = await picture();
  await set('cut', 0.3);
  await colour_by('volume');
  await evaluate('document.getElementById("canvas").focus()');
  await key('ArrowLeft', 'ArrowLeft');
  await until('links: the address has the view',
    async () => (await evaluate('location.hash')).includes('colour=volume'));
  await evaluate('document.activeElement.blur()');
  const kept = await picture(), hash = await evaluate('location.hash');
  await open('square');
  await open('solid', { hash });
  check('links: the view is back', differ(kept, await picture()) < 0.002 && differ(first, kept) > 0.05,
    '' + differ(kept, await picture()));
  await open('square');
  await open('solid', { hash: '#view=1,2,x&show=77' });
  check('links: a broken one is none', differ(first, await picture()) < 0.001);
  check_quiet('links');
  for (const [name, projection] of [['perspective', 0], ['parallel', 1]]) {
    await set('projection', projection);
    const seen = await picture(), place = mkdtempSync(join(tmpdir(), 'pbw-png-'));
    await send('Browser.setDownloadBehavior', { behavior: 'allow', downloadPath: place });
    await click('save');
    const files = () => readdirSync(place).filter(file => file.endsWith('.png'));
    await until('files: a PNG is saved, ' + name, async () => files().length === 1);
    if (files().length) {
      const image = decode(readFileSync(join(place, files()[0])));
      check('files: as large as the picture', image.width === seen.width && image.height === seen.height);
      check('files: it has the picture, ' + name, covered(seen) > 0.1 && differ(image, seen) < 0.02,
        '' + differ(image, seen));
    }
    rmSync(place, { recursive: true, force: true });
  }
  check_quiet('files');
}

// A lattice of 64 cubes, cut through the middle between cells: each has 6 facets and volume 1.
async function test_cells() {
  await open('cells');
  check('cells: half of them', await get('shown') === '32 of 64 cells shown', await get('shown'));
  check('cells: facts', await get('facts') === '64 cells in 3D', await get('facts'));
  await colour_by('facets');
  check('cells: facets', (await get('summary')).startsWith('least 6,'), await get('summary'));
  const closed = await picture();
  await set('explode', 0.5);
  const apart = await picture();
  check('cells: they move apart', differ(closed, apart) > 0.05, '' + differ(closed, apart));
  await set('cut', 1);
  check('cells: all', await get('shown') === '64 of 64 cells shown', await get('shown'));
  check_quiet('cells');
  await open('cells2');
  check('cells in the plane', await get('shown') === '200 of 200 cells shown', await get('shown'));
  check('cells in the plane: mean area', (await get('summary')).includes('mean 0.005,'), await get('summary'));
  check_quiet('cells in the plane');
  await open('whole');
  const whole = covered(await picture());
  await open('parts');
  const share = covered(await picture()) / whole;
  check('cells in a polygon with a notch and a hole', between(share, 0.44, 0.48), '' + share);
  check_quiet('cells in a polygon');
}

// A swarm in a box of 2 by 1, coloured by x in its first frame: from blue on the left to red on the right.
async function test_film() {
  await open('film', { width: 900, height: 700 });
  const frame = async () => (await get('number', 'value')) + ', ' + (await get('label')).split(',')[0];
  check('film: title and note', await get('title') === 'A swarm in a double gyre'
    && (await get('note')).startsWith('Voronoi cells'));
  check('film: begins with the first of 155 frames', await frame() === '1 of 155, frame 2', await frame());
  const first = await picture_of('canvas');
  check('film: twice as wide as high', Math.abs(first.width / first.height - 2) < 0.05);
  const red = left => count({ rgb: first.rgb.filter((_, i) => (Math.floor(i / 3) % first.width < first.width / 2)
    === left) }, (r, g, b) => r > b + 20);
  check('film: blue on the left, red on the right', red(true) < 0.1 && red(false) > 0.8,
    red(true) + ' ' + red(false));
  await click('on');
  check('film: a step', await frame() === '2 of 155, frame 4', await frame());
  await key('ArrowRight', 'ArrowRight');
  await key('ArrowLeft', 'ArrowLeft');
  check('film: steps by keys', await get('number', 'value') === '2 of 155');
  check('film: cells move', differ(first, await picture_of('canvas')) > 0.001);
  await click('back');
  check('film: a step back is the first picture again', differ(first, await picture_of('canvas')) < 0.001);
  await click('back');
  check('film: not before the first', await get('number', 'value') === '1 of 155');
  await set('frame', 154);
  check('film: the slider', await frame() === '155 of 155, frame 310', await frame());
  await click('edges');
  const plain = await picture_of('canvas');
  await click('edges');
  check('film: edges', differ(plain, await picture_of('canvas')) > 0.01);
  check_quiet('film');
  await open('square');
  await open('film', { hash: '#80' });
  check('film: begins where the address says', await get('number', 'value') === '80 of 155');
}

// Playing, with times that the test gives.
async function test_film_speed() {
  await open('film');
  await evaluate('window.requestAnimationFrame = f => { window.next = f; }');
  const at = time => evaluate('{ const f = window.next; window.next = null; f && f(' + time + ');'
    + 'parseInt(document.getElementById("number").value); }');
  const set_speed = value => evaluate('document.getElementById("speed").value = "' + value + '"');
  await evaluate('document.getElementById("play").click()');
  check('film: plays', await get('play') === 'Pause');
  await set_speed(10);
  const slow = [];
  for (const time of [1000, 1050, 1099, 1100, 1199, 1200]) slow.push(await at(time));
  check('film: 10 frames in a second', slow.join() === '2,2,2,3,3,4', slow.join());
  await set_speed(60);
  const fast = [];
  for (const time of [1210, 1217, 1225, 1234]) fast.push(await at(time));
  check('film: 60 frames in a second', fast.join() === '4,5,5,6', fast.join());
  await evaluate('{ const e = document.getElementById("frame"); e.value = 154; e.oninput(); }');
  check('film: the slider pauses', await get('play') === 'Play');
  await evaluate('document.getElementById("play").click()');
  check('film: after the last comes the first', await at(2000) === 1);
  await evaluate('document.getElementById("play").click()');
  check('film: pauses', await get('play') === 'Play' && await at(3000) === 1
    && await evaluate('window.next') === null);
  check_quiet('film, playing');
  await open('square');
  await open('film', { hash: '#2' });
  await key(' ', 'Space');
  await until('film: plays by itself', async () => +(await get('number', 'value')).split(' ')[0] > 4);
  await click('on');
  const stopped = await get('number', 'value');
  await painted();
  check('film: a step pauses', await get('play') === 'Play' && await get('number', 'value') === stopped);
}

async function test_no_webgl() {
  for (const [source, says] of [['HTMLCanvasElement.prototype.getContext = () => null;', 'no WebGL 2 here'],
    ['WebGL2RenderingContext.prototype.getProgramParameter = () => false;', '']]) {
    const { identifier } = await tell('Page.addScriptToEvaluateOnNewDocument', { source });
    await open('solid');
    check('no WebGL: says so', (await get('say')).startsWith('No picture: ' + says), await get('say'));
    check('no WebGL: the histogram is there', await evaluate('document.querySelectorAll("#chart rect").length') > 20);
    await set('cut', 1);
    check('no WebGL: counts', await shown() > 15000);
    await press(300, 300);
    check('no WebGL: a click finds nothing', await get('picked') === '');
    await set('go-kind', 3);
    await type_in('go', 7);
    check('no WebGL: points are found by id', (await get('picked')).startsWith('point 7 ('), await get('picked'));
    check_quiet('no WebGL');
    await tell('Page.removeScriptToEvaluateOnNewDocument', { identifier });
  }
}

const { targetId } = await send('Target.createTarget', { url: 'about:blank' });
session = (await send('Target.attachToTarget', { targetId, flatten: true })).sessionId;
for (const domain of ['Page', 'Runtime', 'Log', 'Network']) await tell(domain + '.enable');
await evaluate('1');
for (const name of ['square', 'corner', 'solid', 'flat', 'threads', 'points', 'terrain', 'million', 'pawn', 'disc',
  'tower', 'ground', 'inside', 'cells', 'cells2', 'whole', 'parts', 'film']) {
  check(name + '.html is there', existsSync(join(folder, name + '.html')));
}
for (const test of [test_square, test_corner, test_solid, test_flat, test_threads, test_terrain, test_points,
  test_model, test_flat_model, test_surface, test_sites, test_named, test_up, test_inside, test_views,
  test_picking, test_measures,
  test_links_and_files, test_million, test_cells, test_film, test_film_speed, test_no_webgl]) {
  try {
    await test();
  } catch (e) {
    check(test.name + ' runs', false, e.stack);
  }
}
await stop();
