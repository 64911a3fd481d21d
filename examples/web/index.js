// index.js: exact Delaunay and regular triangulations in the shape of delaunator and d3-delaunay, by pbw.h as
// WebAssembly.  See index.d.ts for what each member is.
//   import Delaunay, { Delaunay3 } from 'pbw';
//   const { triangles, halfedges, hull } = Delaunay.from([[0, 0], [1, 0], [0, 1]]);
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

// The address of a copy.  Views are made anew after each call: memory that grows detaches the old ones.
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
    return this;
  }

  // Without triangles the points lie on a line: the distinct ones in its order.
  along_line() {
    const { coords, canonical } = this;
    return canonical.filter((c, i) => c === i)
      .sort((i, j) => coords[2 * i] - coords[2 * j] || coords[2 * i + 1] - coords[2 * j + 1]);
  }

  // Counter-clockwise where y points up; on the hull from one side of the boundary to the other.
  *neighbors(i) {
    const { triangles, halfedges, hull } = this, t = this.incident[i];
    if (triangles.length === 0) {
      const at = hull.indexOf(i);
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
