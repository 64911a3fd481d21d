// index.d.ts: exact Delaunay and regular triangulations, in the shape of delaunator and d3-delaunay.
// Points on one circle (sphere) are decided by a fixed rule, so the result is a function of the set of points.

type Numbers = Float64Array | Float32Array | number[];
type Get<P> = (point: P, index: number, points: readonly P[]) => number;

/** What pbw.h refuses: coordinates that are not finite, more than memory holds. */
export class PbwError extends Error {
  /** As in pbw.h, such as 'PBW_ERROR_NOT_FINITE'. */
  readonly status: string;
}

declare class Triangulation {
  readonly dim: 2 | 3;
  /** Packed coordinates; a typed array is kept, not copied: change it and call update(). */
  readonly coords: Float64Array | Float32Array;
  readonly points: Float64Array | Float32Array;
  /** The power distance is squared distance less weight; null without weights. */
  readonly weights: Float64Array | Float32Array | null;
  /** For each point one triangle (tetrahedron) that has it, -1 for duplicates and hidden points. */
  readonly incident: Int32Array;
  /** For each point itself, or the point that it duplicates. */
  readonly canonical: Uint32Array;
  /** Triangulates again, after a change of coords or weights; makes new arrays.  Where it throws, the old ones
   *  stay. */
  update(): this;
  /** The points that share an edge with point i. */
  neighbors(i: number): IterableIterator<number>;
}

export class Delaunay extends Triangulation {
  /** For points that are pairs, or with getters for any other.  getWeight makes the triangulation a regular one. */
  static from<P = readonly [number, number]>(points: Iterable<P>, getX?: Get<P>, getY?: Get<P>,
    getWeight?: Get<P>): Delaunay;
  constructor(coords: Numbers, weights?: Numbers | null);
  /** Three points a triangle, clockwise where y points up and counter-clockwise on a screen.  Empty if all points lie
   *  on a line. */
  readonly triangles: Uint32Array;
  /** Halfedge e runs from triangles[e] to the next corner; halfedges[e] is its opposite, -1 on the hull. */
  readonly halfedges: Int32Array;
  /** The points on the hull in the orientation of triangles, those inside its sides too; of points on a line all
   *  distinct ones in their order. */
  readonly hull: Uint32Array;
  readonly simplices: Uint32Array;
  /** The nearest point, by power distance if there are weights, -1 if there is none.  Quick from a start nearby. */
  find(x: number, y: number, start?: number): number;
}

export class Delaunay3 extends Triangulation {
  static from<P = readonly [number, number, number]>(points: Iterable<P>, getX?: Get<P>, getY?: Get<P>, getZ?: Get<P>,
    getWeight?: Get<P>): Delaunay3;
  constructor(coords: Numbers, weights?: Numbers | null);
  /** Four points a tetrahedron, a b c d with det[b-a, c-a, d-a] > 0.  Empty if all points lie in a plane. */
  readonly tetrahedra: Uint32Array;
  /** adjacent[4 t + k]: the tetrahedron across the facet opposite to corner k of t, -1 on the hull. */
  readonly adjacent: Int32Array;
  /** Three points a facet, counter-clockwise from outside. */
  readonly hull: Uint32Array;
  readonly simplices: Uint32Array;
  /** The tetrahedra around point i. */
  star(i: number): IterableIterator<number>;
  find(x: number, y: number, z: number, start?: number): number;
}

export default Delaunay;
