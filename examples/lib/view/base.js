// Helpers: elements by id, numbers as text, vectors.  The files of this folder become one function, in the order in
// which page.html names them: base, data, measures, colour, camera, chart, scene, marks, draw, panel.

const $ = id => document.getElementById(id), given = $('mesh').dataset, css = name =>
  getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const dim = +given.dim, flat = dim === 2 && given.heights !== '1', n = dim + 1, W = 4096;
// grouped: the simplices around one first corner are a cell, and the facets across from it the cell's.
const grouped = given.cells === '1';
// surface: triangles of a surface in space; else heights are of a mesh over the plane.
const surface = given.surface === '1', space = dim === 3 || surface ? 3 : 2;
const count = +given.simplices, points = +given.points;
const simplex = grouped ? ['cell', 'cells'] : dim === 3 ? ['tetrahedron', 'tetrahedra'] : ['triangle', 'triangles'];
const canvas = $('canvas'), say = text => { $('say').textContent = text; };
const whole = x => Math.round(x).toLocaleString('en-US');
const many = (count, one, more = one + 's') => whole(count) + ' ' + (count === 1 ? one : more);
const short = (x, span = 0) => Number.isInteger(x) && Math.abs(x) < 1e6 ? '' + x
  : Math.abs(x) < 1e-3 * span ? '0' : '' + +x.toPrecision(3);
window.onerror = text => say('This page failed: ' + text);
$('title').textContent = document.title;
$('facts').textContent = grouped ? given.note + ' in ' + dim + 'D'
  : (count ? many(count, ...simplex) + ', ' : '') + many(points, 'point') + ' in ' + space + 'D'
    + (given.note ? '; ' + given.note : '');
canvas.addEventListener('webglcontextlost', () => say('The graphics driver gave up: reload the page.'));

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = a => { const l = Math.hypot(...a) || 1; return a.map(x => x / l); };
