// web.mjs PACKAGE FOLDER [BROWSER]: examples/web as `make web` built it, beside delaunator and d3-delaunay where npm
// put them in FOLDER, and its page in a browser.  FOLDER/little/web is a build with 32 MB of memory.
import { spawn } from 'node:child_process';
import { existsSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

const [where, folder, browser] = process.argv.slice(2);
let passed = 0, failed = 0, skipped = 0;
function check(name, fine, detail = '') {
  if (fine) { passed++; return; }
  failed++;
  console.log('FAILED ' + name + ' ' + detail);
}
function skip(name) { skipped++; console.log('skipped ' + name); }
const from_file = path => import(pathToFileURL(resolve(path)).href);
const same = (a, b) => a.length === b.length && [...a].every((x, i) => x === b[i]);
const next = e => e % 3 === 2 ? e - 2 : e + 1;

let state = 1;
function random() {                          // mulberry32
  let z = state = state + 0x6d2b79f5 | 0;
  z = Math.imul(z ^ z >>> 15, z | 1);
  z ^= z + Math.imul(z ^ z >>> 7, z | 61);
  return ((z ^ z >>> 14) >>> 0) / 4294967296;
}
const randoms = count => Float64Array.from({ length: count }, random);

const { default: Delaunay, Delaunay3, PbwError, Voronoi } = await from_file(join(where, 'index.js'));

// ---- what holds for every triangulation ----

function thrown(work) {
  try { work(); } catch (error) { return error; }
  return null;
}

function check_plane(name, d) {
  const { triangles, halfedges, hull, coords } = d;
  let area = 0, boundary = 0, fine = true;
  for (let e = 0; e < triangles.length; e++) {
    const back = halfedges[e], p = 2 * triangles[e], q = 2 * triangles[next(e)];
    area += coords[p] * coords[q + 1] - coords[q] * coords[p + 1];
    if (back < 0) boundary++;
    else fine &&= halfedges[back] === e && triangles[back] * 2 === q && triangles[next(back)] * 2 === p;
  }
  check(name + ': halfedges match', fine);
  check(name + ': the hull has all boundary edges', boundary === hull.length && new Set(hull).size === hull.length);
  let around = 0;
  for (let i = 0; i < hull.length; i++) {
    const p = 2 * hull[i], q = 2 * hull[(i + 1) % hull.length];
    around += coords[p] * coords[q + 1] - coords[q] * coords[p + 1];
  }
  check(name + ': triangles fill the hull, clockwise', area < 0 && Math.abs(area - around) < 1e-9 * Math.abs(area),
    area + ' ' + around);
}

// The neighbours of all points, from the simplices alone.
function check_neighbors(name, d) {
  const corners = d.dim + 1, sets = Array.from(d.canonical, () => new Set());
  d.simplices.forEach((i, e) => {
    for (let k = e - e % corners; k < e - e % corners + corners; k++) if (k !== e) sets[i].add(d.simplices[k]);
  });
  check(name + ': neighbors', sets.every((set, i) => {
    const list = [...d.neighbors(i)];
    return list.length === set.size && list.every(j => set.has(j));
  }));
}

function check_find(name, d, spread = 1) {
  let wrong = 0;
  for (let k = 0; k < 100; k++) {
    const at = Array.from({ length: d.dim }, () => spread * (1.4 * random() - 0.2)), i = d.find(...at, k);
    for (let j = 0; j < d.canonical.length; j++) wrong += d.power(j, at) < d.power(i, at);
  }
  check(name + ': find is the nearest', wrong === 0, wrong + ' nearer');
}

function test_plane() {
  for (const count of [3, 4, 5, 20, 300, 20000]) {
    const d = new Delaunay(randoms(2 * count));
    check_plane(count + ' points', d);
    check_neighbors(count + ' points', d);
    if (count <= 300) check_find(count + ' points', d);
  }
  const knots = Array.from({ length: 400 }, (_, i) => ({ x: i % 20, y: Math.floor(i / 20) }));
  const lattice = Delaunay.from(knots, p => p.x, p => p.y);
  check('lattice: 722 triangles', lattice.triangles.length === 3 * 722, lattice.triangles.length);
  check('lattice: 76 points on the hull', lattice.hull.length === 76, lattice.hull.length);
  check_plane('lattice', lattice);
  check_neighbors('lattice', lattice);
  check_find('lattice', lattice, 20);
}

function test_weights() {
  const points = randoms(1000), d = new Delaunay(points, randoms(500).map(w => 0.02 * w));
  const hidden = d.incident.reduce((n, t) => n + (t < 0), 0);
  check('weights hide points', hidden > 20 && hidden < 480, hidden);
  check_plane('weights', d);
  check_neighbors('weights', d);
  check_find('weights', d);
  check('equal weights change nothing', same(new Delaunay(points, new Float64Array(500).fill(3)).triangles,
    new Delaunay(points).triangles));
  const by_getter = Delaunay.from([[0, 0], [4, 0], [0, 4], [1, 1]], p => p[0], p => p[1], (p, i) => i === 0 ? 20 : 0);
  check('getWeight hides a point', by_getter.incident[3] === -1 && by_getter.triangles.length === 3);
  const space = new Delaunay3(randoms(900), randoms(300).map(w => w / 10));
  check('weights in space hide points', space.incident.includes(-1));
}

function test_space() {
  for (const count of [4, 5, 30, 2000]) {
    const d = new Delaunay3(randoms(3 * count)), { tetrahedra, adjacent, hull, coords } = d;
    const volume = (a, b, c, o) => {
      const [u, v, w] = [a, b, c].map(i => [0, 1, 2].map(k => coords[3 * i + k] - (o < 0 ? 0 : coords[3 * o + k])));
      return u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2])
        + u[2] * (v[0] * w[1] - v[1] * w[0]);
    };
    let inside = 0, around = 0, flat = 0, fine = true;
    for (let t = 0; t < tetrahedra.length; t += 4) {
      const v = -volume(tetrahedra[t], tetrahedra[t + 1], tetrahedra[t + 2], tetrahedra[t + 3]);
      inside += v, flat += v < 0;
      for (const u of adjacent.subarray(t, t + 4)) {
        fine &&= u < 0 || adjacent.subarray(4 * u, 4 * u + 4).includes(t / 4);
      }
    }
    for (let f = 0; f < hull.length; f += 3) around += volume(hull[f], hull[f + 1], hull[f + 2], -1);
    check(count + ' in space: positive', flat === 0, flat);
    check(count + ' in space: adjacent matches', fine);
    check(count + ' in space: facets of the hull outward', Math.abs(inside - around) < 1e-9, inside + ' ' + around);
    check(count + ' in space: facets of the hull', adjacent.filter(t => t < 0).length === hull.length / 3);
    check_neighbors(count + ' in space', d);
    if (count <= 2000) check_find(count + ' in space', d);
  }
}

function test_few() {
  const none = new Delaunay([]), one = new Delaunay([3, 4]), line = Delaunay.from([[0, 0], [2, 2], [1, 1], [2, 2]]);
  check('no points', none.triangles.length === 0 && none.hull.length === 0 && none.find(0, 0) === -1);
  check('one point', same(one.hull, [0]) && one.find(9, 9) === 0 && [...one.neighbors(0)].length === 0);
  check('points on a line', same(line.hull, [0, 2, 1]) && line.triangles.length === 0 && line.find(3, 3) === 1);
  check('neighbours on a line', same([...line.neighbors(2)], [0, 1]) && same([...line.neighbors(0)], [2]));
  const twice = Delaunay.from([[0, 0], [0, 0], [1, 0], [0, 1]]);
  check('a duplicate', same(twice.canonical, [0, 0, 2, 3]) && twice.find(0, 0, 1) === 0);
  check('a duplicate has no neighbours', [...twice.neighbors(1)].length === 0);
  check('a place that is none', twice.find(NaN, 0) === -1);
  check('points in a plane', new Delaunay3([0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0]).find(1, 1, 5) === 3);
}

function test_errors() {
  const error = thrown(() => new Delaunay([0, 0, 1, NaN]));
  check('not finite', error instanceof PbwError && error.status === 'PBW_ERROR_NOT_FINITE'
    && /finite/.test(error.message), String(error));
  check('odd', /3 numbers/.test(thrown(() => new Delaunay([0, 0, 1]))));
  check('text', thrown(() => new Delaunay('points')) instanceof TypeError);
  check('too few weights', /1 for 2 points/.test(thrown(() => new Delaunay([0, 0, 1, 1], [1]))));
  const d = new Delaunay(Float64Array.of(0, 0, 1, 0, 0, 1, 3, 3)), before = d.triangles;
  d.coords[1] = Infinity;
  check('a failed update throws', thrown(() => d.update()) instanceof PbwError);
  check('and leaves all as it was', d.triangles === before);
  d.coords[1] = -1;
  check('and is mended by the next', d.update() === d && d.triangles !== before);
}

// ---- cells ----

const area = polygon => polygon.slice(1).reduce((sum, b, k) =>
  sum + polygon[k][0] * b[1] - polygon[k][1] * b[0], 0) / 2;
const BOX = [0.1, -0.2, 0.8, 0.9];

// The cell of point i among all points, by cuts of the bounds with every other point.
function brute_cell(d, i, [xmin, ymin, xmax, ymax]) {
  let cell = [[xmin, ymin], [xmax, ymin], [xmax, ymax], [xmin, ymax]];
  for (let j = 0; j < d.canonical.length; j++) {
    if (d.canonical[j] === d.canonical[i]) continue;
    const more = place => d.power(i, place) - d.power(j, place), kept = [];
    cell.forEach((a, k) => {
      const b = cell[(k + 1) % cell.length], p = more(a), q = more(b);
      if (p <= 0) kept.push(a);
      if (p <= 0 !== q <= 0) kept.push([0, 1].map(axis => (a[axis] * q - b[axis] * p) / (q - p)));
    });
    cell = kept;
  }
  return cell.length > 2 ? [...cell, cell[0]] : null;
}

const close = (a, b) => Math.abs(a[0] - b[0]) + Math.abs(a[1] - b[1]) < 1e-9;
// The same circle of places from some start on.
function same_polygon(a, b) {
  if (!a || !b) return !a && !b;
  const n = a.length - 1, at = a.findIndex(place => close(place, b[0]));
  return a.length === b.length && at >= 0 && b.every((place, k) => close(place, a[(at + k) % n]))
    && close(a[0], a[n]) && close(b[0], b[n]);
}

function check_cells(name, d, bounds = BOX) {
  const v = d.voronoi(bounds), count = d.canonical.length, corners = new Map(), short = new Set();
  const mutual = i => [...v.neighbors(i)].every(j => short.has(j) || [...v.neighbors(j)].includes(i));
  let sum = 0, fine = true;
  for (let i = 0; i < count; i++) {
    const cell = v.cellPolygon(i), brute = d.canonical[i] === i ? brute_cell(d, i, bounds) : null;
    // Ties make edges of rounding's length, so areas are compared.
    fine &&= Math.abs((cell ? area(cell) : 0) - (brute ? area(brute) : 0)) < 1e-9;
    sum += cell ? area(cell) : 0;
    cell?.slice(1).forEach((b, k) => { short.add(close(cell[k], b) ? i : -1); });
    for (const place of cell?.slice(1) ?? []) corners.set(place.join(), (corners.get(place.join()) ?? 0) + 1);
  }
  check(name + ': cells are those of all bisectors', fine);
  const [xmin, ymin, xmax, ymax] = bounds;
  check(name + ': cells fill the bounds, each counter-clockwise',
    Math.abs(sum - (xmax - xmin) * (ymax - ymin)) < 1e-9, sum);
  check(name + ': neighbours are mutual', Array.from(d.canonical.keys()).every(i => short.has(i) || mutual(i)));
  check(name + ': indices of cellPolygons', same([...v.cellPolygons()].map(p => p.index),
    Array.from(d.canonical.keys()).filter(i => v.cellPolygon(i))));
  for (let k = 0; k < 20; k++) {
    const at = [2 * random() - 0.5, 2 * random() - 0.5];
    const least = Math.min(...Array.from(d.canonical, i => d.power(i, at)));
    check(name + ': contains', Array.from(d.canonical).every((c, i) => v.contains(i, ...at) ===
      (d.has_cell(i) && d.power(i, at) === least)));
  }
  return corners;
}

function test_cells() {
  for (const count of [3, 7, 60, 400]) {
    const corners = check_cells(count + ' cells', new Delaunay(randoms(2 * count)));
    const alone = [...corners].filter(([place, uses]) => uses < 2 && !/^(0.1|0.8),|,(-0.2|0.9)$/.test(place));
    check(count + ' cells: corners are shared to the bit', alone.length === 0, alone.length);
  }
  const weighted = new Delaunay(randoms(400), randoms(200).map(w => 0.01 * w));
  check('some are hidden', Array.from({ length: 200 }, (_, i) => i).some(i => !weighted.has_cell(i)));
  check_cells('power cells', weighted);
  const lattice = Array.from({ length: 100 }, (_, i) => [i % 10 / 10, (i / 10 | 0) / 10]);
  check_cells('cells of a lattice', Delaunay.from(lattice));
  check_cells('cells far outside', new Delaunay(randoms(60).map(x => 50 * x + 3)));
  check_cells('one cell', new Delaunay([0.3, 0.2]));
  check_cells('two cells', new Delaunay([0.3, 0.2, 0.5, 0.1]));
  check_cells('cells of a pair and its copies', new Delaunay([0.3, 0.2, 0.5, 0.1, 0.3, 0.2, 0.5, 0.1]));
  check_cells('cells on a line', Delaunay.from([[0, 0], [0.5, 0.5], [0.25, 0.25], [0.75, 0.75], [0.5, 0.5]]));
  check_cells('cells on an upright line', Delaunay.from([[0.3, 0], [0.3, 0.7], [0.3, 0.2]]));
  const line = Delaunay.from([[0, 0], [0.25, 0.25], [0.5, 0.5], [0.75, 0.75]], p => p[0], p => p[1],
    (p, i) => i === 2 ? 0.5 : 0);
  check_cells('power cells on a line', line);
  check('a heavy point on a line hides others', same(line.hull, [0, 2, 3]), line.hull);
  const few = new Delaunay(randoms(8)), wide = few.voronoi([-1e9, -1e9, 1e9, 1e9]);
  check('wide bounds', [...few.canonical].every(i => wide.contains(i, few.coords[2 * i], few.coords[2 * i + 1]))
    && Math.abs([...wide.cellPolygons()].reduce((sum, p) => sum + area(p), 0) / 4e18 - 1) < 1e-12);

  const none = new Delaunay([]), one = new Delaunay([3, 4]);
  check('no points: nothing to draw', [none.hullPolygon(), none.render(), none.renderHull(), none.renderPoints(),
    none.voronoi().cellPolygon(0), none.voronoi().render()].every(drawing => drawing === null));
  check('one point', one.render() === null && one.renderHull() === 'M3,4Z'
    && [...one.trianglePolygons()].length === 0);
  check('points on a line: edges and hull', Delaunay.from([[0, 0], [2, 0], [1, 0]]).render() === 'M0,0L1,0M1,0L2,0');
  check('a point that is none', one.voronoi().cellPolygon(7) === null && !one.voronoi().contains(-1, 0, 0)
    && !one.voronoi().contains(0, NaN, 0));
  check('bounds without area', one.voronoi([0, 0, 0, 5]).cellPolygon(0) === null);
  for (const bounds of [[0, 0, 1], [1, 0, 0, 1], [0, 0, NaN, 1], [0, 0, Infinity, 1]]) {
    const error = thrown(() => one.voronoi(bounds));
    check('bounds that are none: ' + bounds, error instanceof RangeError && /bounds/.test(error.message), error);
  }
  const moved = new Delaunay(randoms(60)), v = moved.voronoi(BOX), before = v.circumcenters;
  moved.coords[0] = 0.5;
  check('update', v.update() === v && v.circumcenters !== before && same(v.circumcenters,
    new Delaunay(moved.coords).voronoi().circumcenters) && v instanceof Voronoi);
}

// The segments of a path, each from its lesser end; h and v as renderBounds has them.
function segments(path) {
  const list = [];
  let start, at;
  const line = to => { list.push([at, to].sort((a, b) => a[0] - b[0] || a[1] - b[1])); at = to; };
  for (const [, letter, numbers] of path.matchAll(/([MLZhv])([^MLZhv]*)/g)) {
    const [x, y] = numbers.split(',').map(Number);
    if (letter === 'M') start = at = [x, y];
    if (letter === 'L') line([x, y]);
    if (letter === 'h') line([at[0] + x, at[1]]);
    if (letter === 'v') line([at[0], at[1] + x]);
    if (letter === 'Z') line(start);
  }
  return list.sort((a, b) => a[0][0] - b[0][0] || a[0][1] - b[0][1] || a[1][0] - b[1][0] || a[1][1] - b[1][1]);
}
const same_drawing = (a, b) => (a ??= '', b ??= '', (p => q => p.length === q.length
  && p.every((s, k) => close(s[0], q[k][0]) && close(s[1], q[k][1])))(segments(a))(segments(b)));

// Each method beside that of d3-delaunay, in general position: there both have one answer.
function check_like_d3(D3, count) {
  const coords = randoms(2 * count), ours = new Delaunay(coords), theirs = new D3(coords);
  const v = ours.voronoi(BOX), w = theirs.voronoi(BOX), all = Array.from({ length: count }, (_, i) => i);
  const like = (name, fine) => check(count + ' points: ' + name + ' as d3-delaunay', fine);
  const places = Array.from({ length: 50 }, () => [2 * random() - 0.5, 2 * random() - 0.5]);
  const by_text = list => list.map(String).sort();
  const triangles = d => by_text([...d.trianglePolygons()].map(p => p.slice(1).map(String).sort()));
  const ends = d => all.every(i => d.triangles[next(d.inedges[i])] === i);
  like('cellPolygon', all.every(i => same_polygon(v.cellPolygon(i), w.cellPolygon(i))));
  like('cellPolygons', same([...v.cellPolygons()].map(p => p.index), [...w.cellPolygons()].map(p => p.index)));
  like('neighbors', all.every(i => same([...v.neighbors(i)].sort(), [...w.neighbors(i)].sort())));
  like('contains', all.every(i => places.every(at => v.contains(i, ...at) === w.contains(i, ...at))));
  like('circumcenters', v.circumcenters.length === w.circumcenters.length
    && same_drawing(v.render(), w.render()) && v.circumcenters.every(Number.isFinite));
  like('vectors', v.vectors.every((x, k) => Math.abs(x - w.vectors[k]) < 1e-12));
  like('bounds', [v.xmin, v.ymin, v.xmax, v.ymax].join() === [w.xmin, w.ymin, w.xmax, w.ymax].join());
  like('hullPolygon', same_polygon(ours.hullPolygon(), theirs.hullPolygon()));
  like('trianglePolygons', same(triangles(ours), triangles(theirs)) && same(ours.trianglePolygon(0).flat(),
    [0, 1, 2, 0].flatMap(k => [...coords.subarray(2 * ours.triangles[k], 2 * ours.triangles[k] + 2)])));
  like('inedges', ends(ours) && ends(theirs) && all.every(i =>
    ours.halfedges[ours.inedges[i]] < 0 === theirs.halfedges[theirs.inedges[i]] < 0));
  like('render', same_drawing(ours.render(), theirs.render()));
  like('renderHull', same_drawing(ours.renderHull(), theirs.renderHull()));
  const each = d => Array.from({ length: d.triangles.length / 3 }, (_, t) => d.renderTriangle(t)).join('');
  like('renderTriangle', same_drawing(each(ours), each(theirs)));
  like('renderPoints', ours.renderPoints() === theirs.renderPoints()
    && ours.renderPoints(3) === theirs.renderPoints(undefined, 3));
  like('renderCell', all.every(i => same_drawing(v.renderCell(i), w.renderCell(i))));
  like('renderBounds', v.renderBounds() === w.renderBounds() && same_drawing(v.renderBounds(), w.renderBounds()));
  const called = make => {
    const calls = [], get = (_, name) => (...numbers) => { calls.push([name, ...numbers]); };
    const context = new Proxy({}, { get });
    check(count + ' points: with a context nothing is returned', make(context) === undefined);
    return calls.sort().join(';');
  };
  like('calls of a context', called(c => ours.renderPoints(c, 3)) === called(c => theirs.renderPoints(c, 3))
    && called(c => v.renderBounds(c)) === called(c => w.renderBounds(c)));
}

async function test_memory() {
  const little = await from_file(join(folder, 'little', 'web', 'index.js'));
  for (const [count, what] of [[3e6, 'for the points'], [4e5, 'for the triangulation']]) {
    const error = thrown(() => new little.Delaunay(randoms(2 * count)));
    check('no memory ' + what, error && error.status === 'PBW_ERROR_MEMORY', String(error));
    check('and the next call works', new little.Delaunay(randoms(2000)).triangles.length > 5000);
  }
}

function test_update() {
  const coords = randoms(2000), d = new Delaunay(coords);
  for (let i = 0; i < coords.length; i += 3) coords[i] = random();
  check('coords are kept, not copied', d.coords === coords && d.points === coords);
  check('update', same(d.update().triangles, new Delaunay(coords.slice()).triangles));
  const floats = Float32Array.from(coords), doubles = Float64Array.from(floats);
  check('floats', same(new Delaunay(floats).triangles, new Delaunay(doubles).triangles));
}

// ---- beside delaunator and d3-delaunay ----

function triangle_set({ triangles }) {      // each from its least corner on, so that orientation counts
  const set = new Set();
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = triangles.subarray(t, t + 3);
    set.add((a < b && a < c ? [a, b, c] : b < c ? [b, c, a] : [c, a, b]).join());
  }
  return set;
}
const turned = (list, first) => [...list.slice(list.indexOf(first)), ...list.slice(0, list.indexOf(first))];
const median = list => list.sort((a, b) => a - b)[list.length >> 1];

async function test_rivals() {
  if (!existsSync(join(folder, 'node_modules', 'd3-delaunay'))) return skip('delaunator: npm could not install it');
  const { Rival, D3 } = await from_file(join(folder, 'rivals.mjs'));
  for (const count of [3, 10, 100, 1000, 50000]) {
    const coords = randoms(2 * count), ours = new Delaunay(coords), theirs = new Rival(coords);
    const set = triangle_set(theirs), mine = triangle_set(ours);
    check(count + ': the triangles of delaunator', set.size === mine.size && [...set].every(t => mine.has(t)));
    check(count + ': the hull of delaunator', same(turned([...ours.hull], theirs.hull[0]), [...theirs.hull]));
    const names = ['coords', 'triangles', 'halfedges', 'hull'];
    check(count + ': types', names.every(name => ours[name].constructor === theirs[name].constructor));
  }
  const coords = randoms(1000), ours = new Delaunay(coords), theirs = new D3(coords);
  check('neighbors of d3-delaunay, in its orientation', Array.from({ length: 500 }, (_, i) => i).every(i => {
    const list = [...theirs.neighbors(i)], mine = [...ours.neighbors(i)];
    return mine.length === list.length && same(turned(mine, list[0]), list);
  }));
  check('find of d3-delaunay', Array.from({ length: 300 }, () => [random(), random()])
    .every(at => ours.find(...at) === theirs.find(...at)));
  for (const size of [3, 5, 20, 300]) check_like_d3(D3, size);
  for (const count of [1000, 100000]) {
    const points = randoms(2 * count), times = [[], []];
    for (let k = 0; k < 5; k++) {
      [Delaunay, Rival].forEach((make, i) => {
        const start = performance.now();
        new make(points);
        times[i].push(performance.now() - start);
      });
    }
    const [a, b] = times.map(median);
    console.log(count + ' points: pbw ' + a.toFixed(1) + ' ms, delaunator ' + b.toFixed(1) + ' ms, ratio '
      + (a / b).toFixed(2));
  }
}

// ---- the page, opened as a file ----

const pause = ms => new Promise(done => setTimeout(done, ms));

function start_browser(profile) {
  const chromium = spawn(browser, ['--headless', '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run',
    '--disable-background-networking', '--disable-component-update', '--disable-sync', '--disable-dev-shm-usage',
    '--window-size=1200,760', '--user-data-dir=' + profile, '--remote-debugging-pipe', 'about:blank'],
    { stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe'] });
  const answers = new Map(), events = [];
  let text = '', last = 0;
  chromium.stdio[4].on('data', data => {
    text += data;
    for (let end; (end = text.indexOf('\0')) >= 0; text = text.slice(end + 1)) {
      const message = JSON.parse(text.slice(0, end));
      if (message.id) answers.get(message.id)(message.result ?? {}); else events.push(message);
    }
  });
  const send = (method, params = {}, sessionId = undefined) => new Promise((done, fail) => {
    answers.set(++last, done);
    chromium.once('exit', () => fail(new Error('the browser ended')));
    chromium.once('error', fail);
    chromium.stdio[3].write(JSON.stringify({ id: last, method, params, sessionId }) + '\0');
  });
  chromium.setMaxListeners(0);
  return { chromium, events, send };
}

async function use_page({ events, send }) {
  const { targetId } = await send('Target.createTarget', { url: 'about:blank' });
  const { sessionId } = await send('Target.attachToTarget', { targetId, flatten: true });
  const tell = (method, params) => send(method, params, sessionId);
  const evaluate = async expression => (await tell('Runtime.evaluate', { expression, awaitPromise: true,
    returnByValue: true })).result?.value;
  const numbers = () => evaluate('document.getElementById("numbers").textContent');
  const mouse = (type, x, y) => tell('Input.dispatchMouseEvent', { type, x, y, button: 'left', buttons: 1,
    clickCount: 1 });
  // As many attempts as a busy machine needs, but not without end: then what follows tells what is wrong.
  const until = async (name, fits) => {
    for (let i = 0; i < 20000; i++) {
      if (fits(await numbers() ?? '')) return;
      await pause(20);
    }
    throw new Error(name + ': still ' + await numbers());
  };
  for (const domain of ['Page', 'Runtime', 'Log', 'Network']) await tell(domain + '.enable');
  await tell('Emulation.setDeviceMetricsOverride', { width: 1200, height: 760, deviceScaleFactor: 1,
    mobile: false });
  await tell('Page.navigate', { url: pathToFileURL(resolve(where, 'index.html')).href });
  await until('a thousand points', text => text.includes('1,000 points'));
  await mouse('mousePressed', 740, 720);                  // below the points
  await mouse('mouseReleased', 740, 720);
  const more = await numbers();
  check('page: a click adds a point', more.startsWith('1,001 points'), more);
  await mouse('mousePressed', 740, 720);
  await mouse('mouseMoved', 740, 400);
  await mouse('mouseReleased', 740, 400);
  const after = await numbers();
  check('page: a drag adds none, and changes triangles', after.startsWith('1,001 points') && after !== more, after);
  const shown = await evaluate(`(() => { const c = document.getElementById("stage"), p = c.getContext("2d");
    const d = p.getImageData(0, 0, c.width, c.height).data; let n = 0;
    for (let i = 3; i < d.length; i += 4) n += d[i] > 0; return n / (c.width * c.height); })()`);
  check('page: triangles are drawn', shown > 0.25 && shown < 0.35, shown);
  const pixels = 'document.getElementById("stage").toDataURL()', plain = await evaluate(pixels);
  await evaluate('document.getElementById("cells").click()');
  await evaluate('new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))');
  const legend = await evaluate('document.getElementById("legend").textContent');
  const changed = await evaluate(pixels) !== plain;
  check('page: cells change the picture and the legend', changed && /cell/i.test(legend), legend);
  await evaluate('document.getElementById("kind").value = "uniform"');
  await evaluate('document.querySelector("#counts button:last-child").click()');
  await until('a million points', text => text.startsWith('1,000,000 points'));
  check('page: a million points', /1,999,\d{3} triangles/.test(await numbers()), await numbers());
  console.log('1000000 points in the browser: ' + await evaluate('document.getElementById("seconds").textContent'));
  const bad = events.filter(e => /exceptionThrown|entryAdded|consoleAPICalled/.test(e.method));
  check('page: the console is empty', bad.length === 0, JSON.stringify(bad).slice(0, 500));
  const urls = events.filter(e => e.method === 'Network.requestWillBeSent').map(e => e.params.request.url);
  check('page: nothing else is loaded', urls.length === 1 && urls[0].startsWith('file:'), urls.join(' '));
}

async function test_page() {
  if (!browser) return skip('page: no Chromium');
  const profile = mkdtempSync(join(tmpdir(), 'pbw-web-')), started = start_browser(profile);
  try {
    await use_page(started);
  } finally {
    started.chromium.removeAllListeners('exit');
    started.chromium.kill('SIGKILL');
    await pause(300);
    try { rmSync(profile, { recursive: true, force: true, maxRetries: 5 }); } catch { /* /tmp is swept */ }
  }
}

for (const test of [test_plane, test_weights, test_space, test_few, test_cells, test_errors, test_memory, test_update,
  test_rivals, test_page]) {
  try {
    await test();
  } catch (error) {
    check(test.name + ' runs', false, error.stack);
  }
}
console.log(passed + ' passed, ' + failed + ' failed, ' + skipped + ' skipped');
process.exit(failed > 0 ? 1 : 0);
