/* domain.h: what the files of `pbw plane` share: a plane domain as it is read, its own triangulation, and what its
   points and segments carry to the mesh. */
#ifndef DOMAIN_H
#define DOMAIN_H

#include "program.h"
#include <limits.h>

/* ---- the domain: domain.c, geojson.c ---- */

typedef enum segment_kind { RING, CLOSED_LINE, OPEN_LINE } segment_kind;     /* .poly has RING only */

typedef struct source {                              /* where a segment is from */
    size_t line;                                     /* of the file */
    pbw_index feature;                               /* of GeoJSON, from 0; PBW_NONE: none */
    int marker;                                      /* 0: none */
    segment_kind kind;
} source;

typedef struct plan {
    double *points, *holes, *sizes, *heights;        /* sizes, heights: one a point, or NULL */
    pbw_index *segments, *triangles;                 /* triangles: of a mesh that is there already, or NULL */
    pbw_index *triangle_groups, *segment_groups, *point_groups;      /* of a mesh, or NULL: places in groups */
    source *sources;                                 /* one a segment; NULL: of a mesh */
    int *point_markers;                              /* one a point, or NULL */
    pbw_plane_region *regions;
    pbw_index *region_groups, *feature_groups;       /* one a region, one a feature: places in groups, or PBW_NONE */
    pbwio_group *groups;                             /* of triangles; of a mesh all */
    pbwio_column *columns;                           /* of points */
    size_t point_count, segment_count, hole_count, region_count, triangle_count, group_count, column_count,
           feature_count, polygon_count, line_count;
    int base;                                        /* number of the first point in its file */
    int has_windings, has_seeds, has_groups;         /* polygons; holes as points; groups of a mesh */
} plan;

/* Reads the input of the job, and sizes from a column of it, by name or "#" and number; returns 0 or the exit
   status. */
int read_domain(job *j, plan *d, const char *column);
void domain_free(plan *d);

typedef struct text {
    const char *name;
    const pbw_options *build;                        /* of the job: memory_limit, progress */
    char *data, *at;                                 /* with a 0 behind it */
    size_t line;
    char error[256];                                 /* the first one */
} text;

PRINTF(2, 3) int refuse(text *t, const char *format, ...);           /* returns 0 */
int next_number(text *t, double *x);                                  /* a finite decimal number at t->at */
int grow(void **data, size_t count, size_t size);                    /* room for one more; at powers of two */
int append_point(plan *d, double x, double y);
int append_segment(plan *d, size_t a, size_t b, source from);

/* What names a region: a tag, or a name, which the plan frees. */
typedef struct label { int is; long long tag; char *name; } label;   /* is 0: nothing */
/* Makes the groups of the plan: labels with one tag, or one name, are of one group; names get the tags after the
   largest.  of: the group of each label, or PBW_NONE; it has room for one.  Returns whether there is memory. */
int make_groups(plan *d, const label *labels, size_t count, pbw_index **of);

int read_geojson(job *j, text *t, plan *d);

/* ---- triangles that a file has: remesh.c ---- */

/* The plan owns what the job's cloud had.  Returns 0 or the exit status. */
int take_cloud(job *j, plan *d);
/* The triangles of the plan as a plane, counter-clockwise, to look values up in; corners: they are there, the caller
   frees them.  Returns 0 if there is no memory. */
int view_triangles(const plan *d, pbw_plane *view, pbw_index **corners);
/* Makes the plane of those triangles, with their regions and segments. */
pbw_status make_again(const plan *d, const pbw_plane_options *options, pbw_plane *plane);
/* The plane lists groups instead of segments, so that pieces of lines can be joined: for each edge that of its first
   segment in one.  own: what the caller frees after the plane.  Returns 0 if there is no memory. */
int list_groups(const plan *d, pbw_plane *plane, void *own[2]);
/* The points of the plan again, PBW_NONE for new ones: by their numbers, or those that adapt has kept of the first
   mesh, from.  The caller frees them.  Returns 0 if there is no memory. */
int find_origins(const plan *d, const pbw_plane *plane, const pbw_index *from, pbw_index **origin);
/* Marks the points that are in groups with a name: they stay where they are.  origin: of the points, NULL: they are
   those of the plan.  The caller frees it; NULL: no memory. */
unsigned char *points_to_keep(const plan *d, size_t count, const pbw_index *origin);
/* Moves the points on no segment and in no group with a name. */
pbw_status smooth(const plan *d, pbw_plane *plane, const pbw_index *origin, pbw_plane_way way, int rounds,
                  const pbw_plane_options *options);

/* ---- its own triangulation: survey.c ---- */

/* Triangulates the domain. */
pbw_status make_domain(const plan *d, const pbw_plane_options *options, pbw_plane *plane);
/* Triangulates its points and segments up to the hull, without refinement. */
pbw_status survey(const plan *d, const pbw_plane_options *options, pbw_plane *hull);
/* The regions of features, and holes, by that triangulation and a rule.  Returns 0 or the exit status. */
int find_regions(const job *j, plan *d, const pbw_plane *hull, pbw_plane_rule rule);
/* The regions and holes of a mesh, as .poly needs them: a point in each.  groups: of its triangles, or PBW_NONE.
   Returns 0 or the exit status. */
int seed_mesh(const job *j, plan *d, const pbw_plane *mesh, const pbw_index *groups,
              const pbw_plane_options *options);
/* Say what encloses nothing, and what crosses; the exit status. */
int nothing_enclosed(const job *j, const plan *d, const pbw_plane_options *options);
int crossing(const job *j, const plan *d, const pbw_plane *plane);

/* ---- what it carries: carry.c ---- */

typedef struct carried {                             /* what a mesh of the domain has; start from {0} */
    pbwio_column *columns;                           /* names are the domain's */
    double *heights;
    int *edge_markers, *point_markers;
    pbwio_group *groups;                             /* of triangles, edges and points */
    char (*names)[32];                               /* of regions that have none of their own */
    pbw_index *regions, *patches, *point_groups;     /* of triangles, corners and points: as in pbwio_output */
    pbw_index *edge_groups;                          /* the same of edges */
    size_t column_count, group_count;
    int has_markers;
} carried;

/* own: the triangulation that columns and heights are linear in, or NULL: there are none.  origin: for each point of
   the mesh the point of the domain that it is, or PBW_NONE. */
pbw_status carry(const job *j, const plan *d, const pbw_plane *own, const pbw_plane *mesh, const pbw_index *origin,
                 carried *c);
void carried_free(carried *c);
/* A word about segments and regions that the domain has and the mesh has not. */
void warn_of_losses(const job *j, const plan *d, const pbw_plane *plane);
/* The writers' view of it.  base: as in pbwio_output. */
void show_carried(pbwio_output *output, const carried *c, int base);
/* Points that coincide get the values of the first one, with a word where they differ.  Returns 0: out of memory. */
int unify_duplicates(const job *j, plan *d);

#endif
