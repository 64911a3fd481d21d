// web_use.mjs: a project that installed the package of `make web`, by import and by require.
import { createRequire } from 'node:module';
import Delaunay, { Delaunay3, PbwError, Voronoi } from 'pbw';
const required = createRequire(import.meta.url)('pbw'), square = [[0, 0], [1, 0], [0, 1]];
const fine = [Delaunay, required.Delaunay, required.default].every(make => make.from(square).triangles.length === 3
  && make.from(square).voronoi([0, 0, 1, 1]).cellPolygon(0).length === 5);
if (!fine || !Delaunay3 || !PbwError || !Voronoi || Object.keys(required).length !== 6) process.exit(1);
