/* pbw_stuffing.h - v0.2.0 - tetrahedra for implicit functions by isosurface stuffing - MIT-0

   QUICK START
   Include it where the implementations of pbw.h and pbw_surface.h are included; every function is static.

       pbwst_mesh mesh;
       if (pbwst_make(24, -1, 1, function, NULL, &mesh) == PBW_OK) { // above zero inside
           printf("%u points, %u tetrahedra\n", (unsigned)mesh.points, (unsigned)mesh.tets);
       }                                                             // mesh.x, and mesh.corners: four each
       pbwst_free(&mesh);

   CONTENTS  (search for the marks)
     >>interface    types and functions
     >>lattice      the nodes of two cubic lattices, moved to the surface
     >>tetrahedra   the lattice's tetrahedra: kept, left out, or cut
     >>stages       all of it in order

   FUNCTIONS
     pbwst_make  fills what is inside with tetrahedra
     pbwst_free  frees them

   HOW
   Isosurface stuffing (Labelle and Shewchuk 2007, "Isosurface stuffing: fast tetrahedral meshes with good dihedral
   angles"), with elements of one size; no triangulation is needed.
   1. The function is computed at the nodes of a body-centred cubic lattice.
   2. Nodes that are near the surface move onto it.
   3. Each tetrahedron of the lattice is kept, left out, or cut by the surface into a few.

   PROMISES  (tests/test_mesh3.c guards them)
     angles      dihedral angles are 10.7 to 164.8 degrees, as the paper proves
     manifold    facets fit, and tetrahedra are positively oriented, by exact signs
     always      it fails only if memory is short, an argument is wrong, or options.progress cancels

   DOES NOT  keep sharp edges, which are rounded off, nor parts thinner than a cell.  Points that are no corners
             stay in x.
*/
#ifndef PBW_STUFFING_H
#define PBW_STUFFING_H
#include "pbw_surface.h"
#include <string.h>

#if PBWSF__SEAM != 1
#error "pbw_stuffing.h is compiled where pbw_surface.h of its version is: define PBW_SURFACE_IMPLEMENTATION, too"
#else

/* ------------------------------------------------------------------------------------------------------
   >>interface    Types and functions.
   ------------------------------------------------------------------------------------------------------ */
enum { PBWST__EDGES = 14 };                /* at a node: 6 long ones along axes, 8 short ones to the other lattice */

typedef struct pbwst_mesh {                /* filled by pbwst_make; pbwst_free when done */
    size_t points, tets;
    double (*x)[3];                        /* of each point */
    pbw_index *corners;                    /* four of each tetrahedron */
    pbw_memory memory;                     /* private */
    size_t point_room, corner_room;        /* private */
} pbwst_mesh;

/* Fills what is inside of the cube from low to high, with n nodes along an axis, 4 to 200.  f is above zero inside,
   and must be below zero at the cube's sides.  options: memory_limit; resize, which must outlive the mesh; progress.
   On any status but PBW_OK the mesh is left empty: PBW_ERROR_ARGUMENT, PBW_ERROR_MEMORY, PBW_CANCELLED. */
static pbw_status pbwst_make(int n, double low, double high, double (*f)(const double p[3]),
                             const pbw_options *options, pbwst_mesh *mesh);
static void pbwst_free(pbwst_mesh *mesh);  /* fine on {0}, fine twice */

/* ------------------------------------------------------------------------------------------------------
   >>lattice      The nodes of two cubic lattices, moved to the surface.
   In: numbers and values of nodes.  Out: their neighbours; places where the function is zero; nodes on the surface.
   ------------------------------------------------------------------------------------------------------ */

typedef struct pbwst__work {
    int n;                                 /* nodes along an axis of each of the two lattices */
    double (*f)(const double p[3]);
    double *value;                         /* of each node */
    pbw_index (*cut)[PBWST__EDGES];        /* per node and edge: the point where the surface cuts it, or PBW_NONE */
    pbwst_mesh *mesh;
    double (*x)[3];                        /* mesh->x */
} pbwst__work;

/* Returns the node across edge e of a node; PBW_NONE out of the box. */
static pbw_index pbwst__across(const pbwst__work *s, pbw_index node, int e)
{
    const int n = s->n, body = (int)node >= n * n * n, at = (int)node - body * n * n * n;
    int c[3] = { at % n, at / n % n, at / n / n }, k;
    for (k = 0; k < 3; k++) {
        if (e < 6) {
            c[k] += k == e / 2 ? e % 2 * 2 - 1 : 0;
        } else {
            c[k] += ((e - 6) >> k & 1) - !body;
        }
        if (c[k] < 0 || c[k] >= n) {
            return PBW_NONE;
        }
    }
    return (pbw_index)(((e < 6 ? body : !body) * n + c[2]) * n * n + c[1] * n + c[0]);
}

/* Where the function is zero between two nodes of different signs. */
static void pbwst__find_cut(const pbwst__work *s, pbw_index a, pbw_index b, double out[3])
{
    double from = 0, to = 1;
    int i, k;
    for (i = 0; i < 50; i++) {
        for (k = 0; k < 3; k++) {
            out[k] = s->x[a][k] + (from + to) / 2 * (s->x[b][k] - s->x[a][k]);
        }
        *((s->f(out) > 0) == (s->value[a] > 0) ? &from : &to) = (from + to) / 2;
    }
}

/* Moves a node to the nearest cut of its edges, if that is within the fraction of the edge that the proof needs. */
static void pbwst__warp(pbwst__work *s, pbw_index node)
{
    double best = 1, p[3], place[3];
    int e;
    for (e = 0; e < PBWST__EDGES; e++) {
        const pbw_index other = pbwst__across(s, node, e);
        if (other != PBW_NONE && s->value[node] * s->value[other] < 0) {
            const double limit = e < 6 ? 0.24999 : 0.41189;
            double share;
            pbwst__find_cut(s, node, other, p);
            share = pbwsf__distance(s->x[node], p) / pbwsf__distance(s->x[node], s->x[other]) / limit;
            if (share < best) {
                best = share;
                memcpy(place, p, sizeof place);
            }
        }
    }
    if (best < 1) {
        memcpy(s->x[node], place, sizeof place);
        s->value[node] = 0;
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>tetrahedra   The lattice's tetrahedra: kept, left out, or cut by the surface.
   In: nodes with signs.  Out: tetrahedra.
   Holds: two tetrahedra cut a facet between them in the same way.
   ------------------------------------------------------------------------------------------------------ */
/* Returns the point where the surface cuts the edge from a, inside, to b; b itself if it is on the surface or inside.
   */
static pbw_index pbwst__cut_of(pbwst__work *s, pbw_index a, pbw_index b)
{
    int e = 0;
    if (!(s->value[a] > 0 && s->value[b] < 0)) {
        return b;
    }
    while (pbwst__across(s, a, e) != b) {
        e++;
    }
    if (s->cut[a][e] == PBW_NONE) {
        pbwst__find_cut(s, a, b, s->x[s->mesh->points]);
        s->cut[a][e] = (pbw_index)s->mesh->points++;
    }
    return s->cut[a][e];
}

static void pbwst__add(pbwst__work *s, pbw_index a, pbw_index b, pbw_index c, pbw_index d)
{
    pbw_index *t = s->mesh->corners + 4 * s->mesh->tets;
    if (a != b && a != c && a != d && b != c && b != d && c != d) {
        const int turn = pbw_orient3(s->x[a], s->x[b], s->x[c], s->x[d]) < 0;
        t[0] = a, t[1] = turn ? c : b, t[2] = turn ? b : c, t[3] = d;
        s->mesh->tets++;
    }
}

/* Returns whether the quadrilateral of a, b and the cuts of a-o and b-o is halved from a: if the edge a-o is the
   short one, or, if both are short, by number.  The rule depends on the facet a b o only, so both tetrahedra at it
   agree. */
static int pbwst__from_first(const pbwst__work *s, pbw_index a, pbw_index b, pbw_index o)
{
    const pbw_index half = (pbw_index)(s->n * s->n * s->n);
    const int long_a = (a < half) == (o < half), long_b = (b < half) == (o < half);
    return long_a != long_b ? long_b : a < b;
}

/* Adds the three tetrahedra of a prism with edges from u[i] to w[i].  before[i]: how many diagonals of its sides
   start at u[i]. */
static void pbwst__add_prism(pbwst__work *s, const pbw_index u[3], const pbw_index w[3], const int before[3])
{
    int a = 0, c = 0, b, i;
    for (i = 1; i < 3; i++) {
        a = before[i] > before[a] ? i : a;
        c = before[i] <= before[c] ? i : c;
    }
    b = 3 - a - c;
    pbwst__add(s, u[a], u[b], u[c], w[c]);
    pbwst__add(s, u[a], u[b], w[b], w[c]);
    pbwst__add(s, u[a], w[a], w[b], w[c]);
}

static void pbwst__stuff(pbwst__work *s, const pbw_index v[4])
{
    pbw_index in[4], on[4], out[4];
    int ins = 0, ons = 0, outs = 0, i;
    for (i = 0; i < 4; i++) {
        *(s->value[v[i]] > 0 ? in + ins++ : s->value[v[i]] < 0 ? out + outs++ : on + ons++) = v[i];
    }
    if (outs == 0 && ins > 0) {
        pbwst__add(s, v[0], v[1], v[2], v[3]);
    } else if (ins == 1) {
        for (i = 0; i < outs; i++) {
            on[ons++] = pbwst__cut_of(s, in[0], out[i]);
        }
        pbwst__add(s, in[0], on[0], on[1], on[2]);
    } else if (ins == 2 && outs == 2) {
        const pbw_index u[3] = { in[0], pbwst__cut_of(s, in[0], out[0]), pbwst__cut_of(s, in[0], out[1]) };
        const pbw_index w[3] = { in[1], pbwst__cut_of(s, in[1], out[0]), pbwst__cut_of(s, in[1], out[1]) };
        const int first = pbwst__from_first(s, in[0], in[1], out[0]);
        const int second = pbwst__from_first(s, in[0], in[1], out[1]);
        const int one = first != second ? first < second
                      : pbwsf__distance(s->x[u[1]], s->x[w[2]]) < pbwsf__distance(s->x[u[2]], s->x[w[1]]);
        const int before[3] = { first + second, !first + one, !second + !one };
        pbwst__add_prism(s, u, w, before);
    } else if (ins > 1) {
        const pbw_index last = ins == 3 ? in[2] : on[0], o = out[0];
        const pbw_index u[3] = { in[0], in[1], last }, w[3] = { pbwst__cut_of(s, u[0], o), pbwst__cut_of(s, u[1], o),
                                                                ins == 3 ? pbwst__cut_of(s, last, o) : last };
        const int a = pbwst__from_first(s, u[0], u[1], o), b = ins < 3 || pbwst__from_first(s, u[0], last, o);
        const int c = ins < 3 || pbwst__from_first(s, u[1], last, o), before[3] = { a + b, !a + c, !b + !c };
        pbwst__add_prism(s, u, w, before);
    }
}

/* Makes room for what one tetrahedron of the lattice may add: a point on each of four edges, three tetrahedra. */
static int pbwst__reserve(pbwst__work *s)
{
    pbwst_mesh *mesh = s->mesh;
    const int fits = (mesh->point_room - mesh->points >= 4
                      || pbw_memory_grow(&mesh->memory, &mesh->x, &mesh->point_room, mesh->points, 4,
                                         sizeof *mesh->x))
        && (mesh->corner_room - 4 * mesh->tets >= 12
            || pbw_memory_grow(&mesh->memory, &mesh->corners, &mesh->corner_room, 4 * mesh->tets, 12,
                               sizeof *mesh->corners));
    s->x = mesh->x;
    return fits;
}

/* Stuffs the four tetrahedra around each long edge from a node of the second lattice.  Returns 0 if memory is
   short. */
static int pbwst__stuff_around(pbwst__work *s, pbw_index node)
{
    static const int turn[4] = { 0, 1, 3, 2 };
    int e, f;
    for (e = 1; e < 6; e += 2) {
        const pbw_index next = pbwst__across(s, node, e);
        const int k = e / 2, low = 1 << (k + 1) % 3, high = 1 << (k + 2) % 3;
        for (f = 0; f < 4 && next != PBW_NONE; f++) {
            const int a = turn[f], b = turn[(f + 1) % 4];
            pbw_index v[4];
            v[0] = node;
            v[1] = next;
            v[2] = pbwst__across(s, node, 6 + (1 << k) + (a & 1) * low + (a >> 1) * high);
            v[3] = pbwst__across(s, node, 6 + (1 << k) + (b & 1) * low + (b >> 1) * high);
            if (v[2] != PBW_NONE && v[3] != PBW_NONE) {
                if (!pbwst__reserve(s)) {
                    return 0;
                }
                pbwst__stuff(s, v);
            }
        }
    }
    return 1;
}

/* ------------------------------------------------------------------------------------------------------
   >>stages       All of it in order.
   In: a function.  Out: tetrahedra.
   ------------------------------------------------------------------------------------------------------ */
static void pbwst_free(pbwst_mesh *mesh)
{
    if (mesh->memory.resize != NULL) {
        (void)pbw_memory_fit(&mesh->memory, &mesh->x, &mesh->point_room, 0, sizeof *mesh->x);
        (void)pbw_memory_fit(&mesh->memory, &mesh->corners, &mesh->corner_room, 0, sizeof *mesh->corners);
    }
    memset(mesh, 0, sizeof *mesh);
}

/* Three passes over the nodes: values, moves, tetrahedra; each reports a layer of nodes at a time. */
static pbw_status pbwst__passes(pbwst__work *s, double low, double high, const pbw_options *options)
{
    const size_t n = (size_t)s->n, half = n * n * n, nodes = 2 * half;
    size_t i, k;
    int pass;
    for (pass = 0; pass < 3; pass++) {
        for (i = pass < 2 ? 0 : half; i < nodes; i++) {
            if (i % (n * n) == 0 && options != NULL && options->progress != NULL
                && options->progress(options->progress_user, PBW_STAGE_WORK,
                                     (pass + (double)i / (double)nodes) / 3)) {
                return PBW_CANCELLED;
            }
            if (pass == 0) {
                const size_t at = i % half, c[3] = { at % n, at / n % n, at / n / n };
                for (k = 0; k < 3; k++) {
                    s->x[i][k] = low + (high - low) * ((double)c[k] + (i < half ? 0 : 0.5)) / (s->n - 0.5);
                }
                s->value[i] = s->f(s->x[i]);
            } else if (pass == 1) {
                pbwst__warp(s, (pbw_index)i);
            } else if (!pbwst__stuff_around(s, (pbw_index)i)) {
                return PBW_ERROR_MEMORY;
            }
        }
    }
    return PBW_OK;
}

static pbw_status pbwst_make(int n, double low, double high, double (*f)(const double p[3]),
                             const pbw_options *options, pbwst_mesh *mesh)
{
    pbwst__work s;
    const size_t nodes = n >= 4 && n <= 200 ? 2 * (size_t)n * (size_t)n * (size_t)n : 0;
    pbw_status status = PBW_ERROR_MEMORY;
    if (mesh == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    memset(mesh, 0, sizeof *mesh);
    if (nodes == 0 || f == NULL || !(low < high)) {
        return PBW_ERROR_ARGUMENT;
    }
    pbw_memory_start(&mesh->memory, options);
    memset(&s, 0, sizeof s);
    s.n = n;
    s.f = f;
    s.mesh = mesh;
    s.value = (double *)pbw_memory_resize(&mesh->memory, NULL, 0, nodes, sizeof *s.value);
    s.cut = (pbw_index (*)[PBWST__EDGES])pbw_memory_resize(&mesh->memory, NULL, 0, nodes, sizeof *s.cut);
    if (s.value != NULL && s.cut != NULL
        && pbw_memory_fit(&mesh->memory, &mesh->x, &mesh->point_room, nodes, sizeof *mesh->x)) {
        memset(s.cut, 0xff, nodes * sizeof *s.cut);
        mesh->points = nodes;
        s.x = mesh->x;
        status = pbwst__passes(&s, low, high, options);
    }
    (void)pbw_memory_resize(&mesh->memory, s.value, s.value != NULL ? nodes : 0, 0, sizeof *s.value);
    (void)pbw_memory_resize(&mesh->memory, s.cut, s.cut != NULL ? nodes : 0, 0, sizeof *s.cut);
    if (status != PBW_OK) {
        pbwst_free(mesh);
    }
    return status;
}

#endif /* PBWSF__SEAM */
#endif /* PBW_STUFFING_H */
