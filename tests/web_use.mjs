// web_use.mjs: a project that installed the package of `make web`.
import Delaunay, { Delaunay3, PbwError } from 'pbw';
if (Delaunay.from([[0, 0], [1, 0], [0, 1]]).triangles.length !== 3 || !Delaunay3 || !PbwError) process.exit(1);
