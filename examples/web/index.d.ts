// index.d.ts: exact Delaunay and regular triangulations, in the shape of delaunator and d3-delaunay.
// Points on one circle (sphere) are decided by a fixed rule, so the result is a function of the set of points.

type Numbers = Float64Array | Float32Array | number[];
type Get<P> = (point: P, index: number, points: readonly P[]) => number;

/** What paths are drawn in: a CanvasRenderingContext2D, a d3-path, ...  Without one a render method returns the text
 *  for the d of an SVG path, null where there is nothing to draw. */
export interface PathContext {
  moveTo(x: number, y: number): void;
  lineTo(x: number, y: number): void;
  closePath(): void;
  rect(x: number, y: number, width: number, height: number): void;
  arc(x: number, y: number, radius: number, from: number, to: number): void;
}
export type Place = [x: number, y: number];
/** Places of which the last is the first. */
export type Polygon = Place[];
/** [xmin, ymin, xmax, ymax] */
export type Bounds = readonly [number, number, number, number] | Float64Array | Float32Array;

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
   *  distinct ones in their order, less those that heavier ones hide. */
  readonly hull: Uint32Array;
  /** For each point a halfedge that ends there, for a point on the hull that of the hull; -1 for a point in no
   *  triangle. */
  readonly inedges: Int32Array;
  readonly simplices: Uint32Array;
  /** The nearest point, by power distance if there are weights, -1 if there is none.  Quick from a start nearby. */
  find(x: number, y: number, start?: number): number;
  /** Whether point i has a cell: it is no duplicate, and no weight hides it. */
  has_cell(i: number): boolean;

  /** The hull, null where there is no point; of points on a line to and fro. */
  hullPolygon(): Polygon | null;
  trianglePolygon(t: number): Polygon;
  trianglePolygons(): IterableIterator<Polygon>;
  /** The edges, each once. */
  render(): string | null;
  render(context: PathContext): void;
  renderHull(): string | null;
  renderHull(context: PathContext): void;
  renderTriangle(t: number): string | null;
  renderTriangle(t: number, context: PathContext): void;
  /** A disk for each point; the radius is 2 unless given. */
  renderPoints(radius?: number): string | null;
  renderPoints(context: undefined, radius?: number): string | null;
  renderPoints(context: PathContext, radius?: number): void;

  /** The Voronoi cells in a box, [0, 0, 960, 500] unless given; power cells if there are weights. */
  voronoi(bounds?: Bounds): Voronoi;
}

/** A view of a triangulation, which makes each cell when asked.  Cells that share a corner have it equal to the bit,
 *  but where lines cross at angles of rounding's size. */
export class Voronoi {
  /** Throws a RangeError where bounds are not four finite numbers in order. */
  constructor(delaunay: Delaunay, bounds?: Bounds);
  readonly delaunay: Delaunay;
  readonly xmin: number;
  readonly ymin: number;
  readonly xmax: number;
  readonly ymax: number;
  /** Two numbers a triangle: the center of its circle, of equal power to its corners if there are weights. */
  readonly circumcenters: Float64Array;
  /** Four numbers a point: the directions of the two edges without end of a cell on the hull, else zeros. */
  readonly vectors: Float64Array;
  /** Calls delaunay.update(), after a change of its coords or weights. */
  update(): this;
  /** Whether no point is nearer to x, y than i, by power distance if there are weights; bounds play no part. */
  contains(i: number, x: number, y: number): boolean;
  /** The points that share an edge with the cell of i inside the bounds.  Where more than three cells meet, rounding
   *  may leave an edge without length, which one of two neighbours has and the other has not. */
  neighbors(i: number): IterableIterator<number>;
  /** The part of the cell inside the bounds, counter-clockwise where y points up; null where there is none, as for
   *  duplicates and hidden points. */
  cellPolygon(i: number): Polygon | null;
  /** Those that are not null; index is the point. */
  cellPolygons(): IterableIterator<Polygon & { index: number }>;
  /** The edges between cells, each once. */
  render(): string | null;
  render(context: PathContext): void;
  renderBounds(): string;
  renderBounds(context: PathContext): void;
  renderCell(i: number): string | null;
  renderCell(i: number, context: PathContext): void;
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
