// index.js: exact Delaunay and regular triangulations in the shape of delaunator and d3-delaunay, by pbw.h as
// WebAssembly.  See index.d.ts for what each member is.
//   import Delaunay, { Delaunay3 } from 'pbw';
//   const { triangles, halfedges, hull } = Delaunay.from([[0, 0], [1, 0], [0, 1]]);
// `make web` makes index.cjs of it, for require('pbw').
// Every array belongs to JavaScript: there is nothing to free.
import { wasm } from './wasm.js';

// ---- the module ----

const code = await WebAssembly.compile(Uint8Array.from(atob(wasm), c => c.charCodeAt(0)));
const imports = {
  env: { emscripten_notify_memory_growth() {} },
  wasi_snapshot_preview1: {
    clock_time_get(id, precision, at) {
      new DataView(instance.memory.buffer).setBigUint64(at >>> 0, BigInt(Math.round(performance.now() * 1e6)), true);
      return 0;
    }
  }
};
const KEPT_BYTES = 1 << 26;
const STATUSES = ['OK', 'DEGENERATE', 'CANCELLED', 'ERROR_ARGUMENT', 'ERROR_NOT_FINITE', 'ERROR_TOO_LARGE',
  'ERROR_MEMORY', 'ERROR_THREAD', 'ERROR_FP_MODE', 'ERROR_BACKEND'];
const OK = 0, DEGENERATE = 1, MEMORY = 6;
let instance = null;

// Memory of WebAssembly grows and never shrinks, so an instance that grew large is left to the garbage collector.
function enter(work) {
  try {
    if (instance === null) {
      instance = new WebAssembly.Instance(code, imports).exports;
      instance._initialize();
    }
    const result = work(instance);
    if (instance.memory.buffer.byteLength > KEPT_BYTES) instance = null;
    return result;
  } catch (error) {
    instance = null;
    throw error;
  }
}

function text_of(module, status) {
  const bytes = new Uint8Array(module.memory.buffer, module.web_text(status) >>> 0);
  return new TextDecoder().decode(bytes.subarray(0, bytes.indexOf(0)));
}

export class PbwError extends Error {
  constructor(status, message) {
    super(message);
    this.name = 'PbwError';
    this.status = 'PBW_' + STATUSES[status];
  }
}

// The address of a copy.  Views are made again after each call: memory that grows detaches the old ones.
function put(module, numbers) {
  const at = module.malloc(Math.max(8 * numbers.length, 8)) >>> 0;
  if (at === 0) throw new PbwError(MEMORY, text_of(module, MEMORY));
  new Float64Array(module.memory.buffer, at, numbers.length).set(numbers);
  return at;
}

// Arrays in the form of web_mesh in pbw_web.c, copied.
function triangulate(dim, coords, weights) {
  const count = coords.length / dim, corners = dim + 1;
  return enter(module => {
    const points = put(module, coords), w = weights ? put(module, weights) : 0;
    const at = module.web_triangulate(dim, points, w, count) >>> 0;
    if (at === 0) throw new PbwError(MEMORY, text_of(module, MEMORY));
    const heap = module.memory.buffer, fields = new Uint32Array(heap, at, 8);
    const [status, simplices, facets] = fields;
    if (status !== OK && status !== DEGENERATE) throw new PbwError(status, text_of(module, status));
    const take = (k, length) => new Uint32Array(heap, fields[k], length).slice();
    const result = {
      simplices: take(3, corners * simplices),
      adjacent: new Int32Array(take(4, corners * simplices).buffer),
      hull: take(5, dim === 2 ? facets : 3 * facets),
      incident: new Int32Array(take(6, count).buffer),
      canonical: take(7, count)
    };
    module.web_free(at);
    return result;
  });
}

// ---- what triangulations in the plane and in space share ----

const next = e => e % 3 === 2 ? e - 2 : e + 1;
const last = e => e % 3 === 0 ? e + 2 : e - 1;

// Packed numbers, one for each getter and point.
function gather(points, getters) {
  const numbers = [];
  let i = 0;
  for (const point of points) {
    for (const get of getters) numbers.push(+get(point, i, points));
    i++;
  }
  return Float64Array.from(numbers);
}

function checked(name, numbers) {
  if (ArrayBuffer.isView(numbers)) return numbers;
  if (!Array.isArray(numbers)) throw new TypeError(name + ': expected an array of numbers');
  return Float64Array.from(numbers);
}

class Triangulation {
  constructor(dim, coords, weights) {
    this.dim = dim;
    this.coords = checked('coords', coords);
    this.weights = weights === undefined || weights === null ? null : checked('weights', weights);
    this.update();
  }

  // The arrays of the changed coords and weights; where that fails, all arrays stay as they were.
  arrays() {
    const { dim, coords, weights } = this;
    if (coords.length % dim !== 0) {
      throw new RangeError('coords: ' + coords.length + ' numbers are no multiple of ' + dim);
    }
    if (weights && weights.length !== coords.length / dim) {
      throw new RangeError('weights: ' + weights.length + ' for ' + coords.length / dim + ' points');
    }
    return triangulate(dim, coords, weights);
  }

  // The squared distance to point i, less its weight.
  power(i, at) {
    let sum = this.weights ? -this.weights[i] : 0;
    for (let k = 0; k < this.dim; k++) sum += (at[k] - this.coords[this.dim * i + k]) ** 2;
    return sum;
  }

  // From vertex to nearer vertex; a Delaunay (regular) triangulation has no other minimum than the nearest.
  nearest(start, at) {
    if (at.some(Number.isNaN) || this.canonical.length === 0) return -1;
    if (this.simplices.length === 0) return this.nearest_of_all(at);
    let best = this.canonical[start], least;
    if (best === undefined || this.incident[best] < 0) best = this.simplices[0];
    least = this.power(best, at);
    for (let from = -1; from !== best;) {
      from = best;
      for (const i of this.neighbors(from)) {
        const power = this.power(i, at);
        if (power < least) least = power, best = i;
      }
    }
    return best;
  }

  nearest_of_all(at) {
    let best = 0;
    for (let i = 1; i < this.canonical.length; i++) if (this.power(i, at) < this.power(best, at)) best = i;
    return this.canonical[best];
  }
}

// ---- paths: drawn in a context of a canvas; without one, text for the d of an SVG path, null where it is empty ----

class Path {
  text = '';
  moveTo(x, y) { this.text += 'M' + x + ',' + y; }
  lineTo(x, y) { this.text += 'L' + x + ',' + y; }
  closePath() { this.text += 'Z'; }
  rect(x, y, w, h) { this.text += 'M' + x + ',' + y + 'h' + w + 'v' + h + 'h' + -w + 'Z'; }
  arc(x, y, r) {
    const half = 'A' + r + ',' + r + ',0,1,1,';
    this.text += half + (x - r) + ',' + y + half + (x + r) + ',' + y;
  }
}

function drawn(context, draw) {
  const path = context ?? new Path();
  draw(path);
  return context ? undefined : path.text || null;
}

// A closed polygon: the last place is the first.
function trace(path, polygon) {
  polygon?.slice(0, -1).forEach(([x, y], k) => k === 0 ? path.moveTo(x, y) : path.lineTo(x, y));
  if (polygon) path.closePath();
}

// ---- the plane ----

export class Delaunay extends Triangulation {
  static from(points, getX = p => p[0], getY = p => p[1], getWeight = undefined) {
    const list = Array.isArray(points) ? points : Array.from(points);
    return new Delaunay(gather(list, [getX, getY]), getWeight && gather(list, [getWeight]));
  }

  constructor(coords, weights = undefined) { super(2, coords, weights); }

  get points() { return this.coords; }
  get simplices() { return this.triangles; }

  update() {
    const made = this.arrays();
    this.triangles = made.simplices;
    this.halfedges = made.adjacent;
    this.canonical = made.canonical;
    this.incident = made.incident;
    this.hull = made.simplices.length > 0 ? made.hull : this.along_line();
    this.place = new Int32Array(made.canonical.length).fill(-1);
    this.hull.forEach((i, k) => { this.place[i] = k; });
    this.inedges = new Int32Array(made.canonical.length).fill(-1);
    made.simplices.forEach((i, e) => { this.inedges[i] = last(e); });
    made.adjacent.forEach((back, e) => { if (back < 0) this.inedges[made.simplices[next(e)]] = e; });
    return this;
  }

  // Without triangles the points lie on a line: the distinct ones in its order that have a cell.
  along_line() {
    const { coords, canonical, weights } = this, shown = [];
    const reach = (i, j) => {                            // from i to where the cells of i and j would meet
      const length = Math.hypot(coords[2 * j] - coords[2 * i], coords[2 * j + 1] - coords[2 * i + 1]);
      return (length + (weights ? weights[i] - weights[j] : 0) / length) / 2;
    };
    const hidden = (i, j, k) => reach(j, i) + reach(j, k) <= 0;
    for (const i of canonical.filter((c, k) => c === k)
      .sort((i, j) => coords[2 * i] - coords[2 * j] || coords[2 * i + 1] - coords[2 * j + 1])) {
      while (shown.length > 1 && hidden(shown.at(-2), shown.at(-1), i)) shown.pop();
      shown.push(i);
    }
    return Uint32Array.from(shown);
  }

  // Counter-clockwise where y points up; on the hull from one side of the boundary to the other.
  *neighbors(i) {
    const { triangles, halfedges, hull } = this, t = this.incident[i];
    if (triangles.length === 0) {
      const at = this.place[i];
      if (at > 0) yield hull[at - 1];
      if (at >= 0 && at + 1 < hull.length) yield hull[at + 1];
    } else if (t >= 0) {
      let e = 3 * t;
      while (triangles[e] !== i) e++;
      const first = e;
      for (let back; (back = halfedges[last(e)]) >= 0 && back !== first;) e = back;         // to the boundary
      const start = e;
      do {
        yield triangles[last(e)];
        if (halfedges[e] < 0) yield triangles[next(e)];
        e = halfedges[e] < 0 ? start : next(halfedges[e]);
      } while (e !== start);
    }
  }

  find(x, y, start = 0) { return this.nearest(start, [+x, +y]); }

  // Whether point i has a cell: is a vertex, or is seen on the line.
  has_cell(i) { return this.incident[i] >= 0 || this.triangles.length === 0 && this.place[i] >= 0; }

  polygon(list) {
    const places = Array.from(list, i => [this.coords[2 * i], this.coords[2 * i + 1]]);
    if (places.length === 0) return null;
    places.push(places[0].slice());
    return places;
  }
  hullPolygon() { return this.polygon(this.hull); }
  trianglePolygon(t) { return this.polygon(this.triangles.subarray(3 * t, 3 * t + 3)); }
  *trianglePolygons() {
    for (let t = 0; 3 * t < this.triangles.length; t++) yield this.trianglePolygon(t);
  }

  render(context) {
    const { coords, triangles, halfedges, hull } = this;
    const draw = (path, i, j) => {
      path.moveTo(coords[2 * i], coords[2 * i + 1]);
      path.lineTo(coords[2 * j], coords[2 * j + 1]);
    };
    return drawn(context, path => {
      triangles.forEach((i, e) => { if (halfedges[e] < e) draw(path, i, triangles[next(e)]); });
      if (triangles.length === 0) for (let k = 1; k < hull.length; k++) draw(path, hull[k - 1], hull[k]);
    });
  }
  renderHull(context) { return drawn(context, path => trace(path, this.hullPolygon())); }
  renderTriangle(t, context) { return drawn(context, path => trace(path, this.trianglePolygon(t))); }
  renderPoints(context, radius = 2) {
    if (typeof context === 'number') return this.renderPoints(undefined, context);
    const { coords } = this, r = +radius;
    return drawn(context, path => {
      for (let k = 0; k < coords.length; k += 2) {
        path.moveTo(coords[k] + r, coords[k + 1]);
        path.arc(coords[k], coords[k + 1], r, 0, 2 * Math.PI);
      }
    });
  }

  voronoi(bounds = undefined) { return new Voronoi(this, bounds); }
}

// ---- Voronoi cells, power cells where there are weights ----

// Sides of the bounds, as the neighbours across an edge.
const YMIN = -1, XMAX = -2, YMAX = -3, XMIN = -4;

export class Voronoi {
  constructor(delaunay, bounds = [0, 0, 960, 500]) {
    const [xmin, ymin, xmax, ymax] = Array.from(bounds, Number);
    if (!(xmax >= xmin && ymax >= ymin && xmax - xmin < Infinity && ymax - ymin < Infinity)) {
      throw new RangeError('bounds: expected [xmin, ymin, xmax, ymax], not [' + Array.from(bounds) + ']');
    }
    Object.assign(this, { delaunay, xmin, ymin, xmax, ymax });
  }

  update() {
    this.delaunay.update();
    return this;
  }

  // Of each triangle; made when first asked for, and for each update.
  get circumcenters() {
    const { triangles } = this.delaunay;
    if (this.centers_of !== triangles) {
      this.centers_of = triangles;
      this.centers = new Float64Array(2 * triangles.length / 3);
      for (let t = 0; 3 * t < triangles.length; t++) {
        this.centers.set(this.center(...triangles.subarray(3 * t, 3 * t + 3)), 2 * t);
      }
    }
    return this.centers;
  }

  // The directions of the two edges without end of the cells on the hull, zeros for all others.
  get vectors() {
    const { hull, coords, triangles } = this.delaunay, vectors = new Float64Array(2 * coords.length);
    if (triangles.length > 0) {
      hull.forEach((j, k) => {
        const i = hull[k > 0 ? k - 1 : hull.length - 1];
        const outward = [coords[2 * i + 1] - coords[2 * j + 1], coords[2 * j] - coords[2 * i]];
        vectors.set(outward, 4 * i + 2);
        vectors.set(outward, 4 * j);
      });
    }
    return vectors;
  }

  // [dx, dy, c]: at p_i + v the powers of i and j are equal where dx v_x + dy v_y = c; where it is more, j's is less.
  bisector(i, j) {
    const { coords, weights } = this.delaunay;
    const dx = coords[2 * j] - coords[2 * i], dy = coords[2 * j + 1] - coords[2 * i + 1];
    return [dx, dy, (dx * dx + dy * dy + (weights ? weights[i] - weights[j] : 0)) / 2];
  }

  // The place of equal power to three points: the same to the bit in every order of them.
  center(i, j, k) {
    const { coords } = this.delaunay, least = Math.min(i, j, k), most = Math.max(i, j, k);
    const [ax, ay, a] = this.bisector(least, i ^ j ^ k ^ least ^ most), [bx, by, b] = this.bisector(least, most);
    const det = ax * by - ay * bx;
    return [coords[2 * least] + (a * by - b * ay) / det, coords[2 * least + 1] + (ax * b - bx * a) / det];
  }

  // The corner of i's cell between its edges with j, or along a side, and with k: the same in the cells of j and k.
  corner(i, j, k) {
    const { xmin, ymin, xmax, ymax } = this, { coords } = this.delaunay;
    let x, y;
    if (j >= 0) {
      [x, y] = this.center(i, j, k);
    } else {
      const o = Math.min(i, k), [dx, dy, c] = this.bisector(o, Math.max(i, k));
      if (j === YMIN || j === YMAX) {
        y = j === YMIN ? ymin : ymax;
        x = coords[2 * o] + (c - dy * (y - coords[2 * o + 1])) / dx;
      } else {
        x = j === XMIN ? xmin : xmax;
        y = coords[2 * o + 1] + (c - dx * (x - coords[2 * o])) / dy;
      }
    }
    return [Math.min(Math.max(x, xmin), xmax), Math.min(Math.max(y, ymin), ymax)];
  }

  // The part of i's cell on its side of the bisector with j.  A cell has corners at; beyond the edge from at[k] is
  // across[k].
  cut(cell, i, j) {
    const { at, across } = cell, [dx, dy, c] = this.bisector(i, j), { coords } = this.delaunay;
    const beyond = at.map(([x, y]) => dx * (x - coords[2 * i]) + dy * (y - coords[2 * i + 1]) - c);
    if (!beyond.some(value => value > 0)) return cell;
    const kept = { at: [], across: [] };
    const put = (place, neighbor) => { kept.at.push(place), kept.across.push(neighbor); };
    at.forEach((a, k) => {
      const l = k + 1 < at.length ? k + 1 : 0, b = at[l], crosses = beyond[k] > 0 !== beyond[l] > 0;
      if (beyond[k] <= 0) put(a, across[k]);
      if (!crosses) return;
      let place = this.corner(i, across[k], j);
      const near = (p, q) => Math.abs(p[0] - q[0]) + Math.abs(p[1] - q[1]);
      if (!(near(a, place) <= 2 * near(a, b))) {         // lines almost parallel: their crossing is lost in rounding
        const f = beyond[k] / (beyond[k] - beyond[l]);
        place = [a[0] + f * (b[0] - a[0]), a[1] + f * (b[1] - a[1])];
      }
      put(place, beyond[k] > 0 ? across[k] : j);
    });
    return kept;
  }

  // Corners and the neighbours across edges, counter-clockwise where y points up; null where nothing is inside.
  cell(i) {
    const { delaunay, xmin, ymin, xmax, ymax } = this;
    if (!delaunay.has_cell(i)) return null;
    let cell = { at: [[xmin, ymin], [xmax, ymin], [xmax, ymax], [xmin, ymax]], across: [YMIN, XMAX, YMAX, XMIN] };
    for (const j of delaunay.neighbors(i)) cell = this.cut(cell, i, j);
    const { at, across } = cell;
    const long = at.map((a, k) => (b => a[0] !== b[0] || a[1] !== b[1])(at[k + 1 < at.length ? k + 1 : 0]));
    if (long.filter(Boolean).length < 3) return null;
    return { at: at.filter((_, k) => long[k]), across: across.filter((_, k) => long[k]) };
  }

  contains(i, x, y) {
    const { delaunay } = this, at = [+x, +y];
    if (!delaunay.has_cell(i) || at.some(Number.isNaN)) return false;
    const own = delaunay.power(i, at);
    for (const j of delaunay.neighbors(i)) if (delaunay.power(j, at) < own) return false;
    return true;
  }

  *neighbors(i) {
    for (const j of this.cell(i)?.across ?? []) if (j >= 0) yield j;
  }

  cellPolygon(i) {
    const cell = this.cell(i);
    if (cell) cell.at.push(cell.at[0].slice());
    return cell && cell.at;
  }
  *cellPolygons() {
    for (let i = 0; i < this.delaunay.canonical.length; i++) {
      const polygon = this.cellPolygon(i);
      if (polygon) yield Object.assign(polygon, { index: i });
    }
  }

  render(context) {
    return drawn(context, path => {
      for (let i = 0; i < this.delaunay.canonical.length; i++) {
        const cell = this.cell(i);
        cell?.across.forEach((j, k) => {
          if (j < i) return;                             // a side, or drawn with j
          path.moveTo(...cell.at[k]);
          path.lineTo(...cell.at[k + 1 < cell.at.length ? k + 1 : 0]);
        });
      }
    });
  }
  renderBounds(context) {
    const { xmin, ymin, xmax, ymax } = this;
    return drawn(context, path => path.rect(xmin, ymin, xmax - xmin, ymax - ymin));
  }
  renderCell(i, context) { return drawn(context, path => trace(path, this.cellPolygon(i))); }
}

// ---- space ----

export class Delaunay3 extends Triangulation {
  static from(points, getX = p => p[0], getY = p => p[1], getZ = p => p[2], getWeight = undefined) {
    const list = Array.isArray(points) ? points : Array.from(points);
    return new Delaunay3(gather(list, [getX, getY, getZ]), getWeight && gather(list, [getWeight]));
  }

  constructor(coords, weights = undefined) { super(3, coords, weights); }

  get points() { return this.coords; }
  get simplices() { return this.tetrahedra; }

  update() {
    const made = this.arrays();
    this.tetrahedra = made.simplices;
    this.adjacent = made.adjacent;
    this.hull = made.hull;
    this.canonical = made.canonical;
    this.incident = made.incident;
    return this;
  }

  // The tetrahedra around point i, none for a point that is no vertex.
  *star(i) {
    const { tetrahedra, adjacent } = this, first = this.incident[i];
    if (!(first >= 0)) return;
    const seen = new Set([first]);
    for (const t of seen) {
      yield t;
      for (let e = 4 * t; e < 4 * t + 4; e++) if (tetrahedra[e] !== i && adjacent[e] >= 0) seen.add(adjacent[e]);
    }
  }

  *neighbors(i) {
    const seen = new Set([i]);
    for (const t of this.star(i)) {
      for (let e = 4 * t; e < 4 * t + 4; e++) {
        const j = this.tetrahedra[e];
        if (!seen.has(j)) seen.add(j), yield j;
      }
    }
  }

  find(x, y, z, start = 0) { return this.nearest(start, [+x, +y, +z]); }
}

export default Delaunay;
