/* faults.c: what is wrong with a surface.
   In: triangles.  Out: lines of the report; outputs: the surface in groups of faces and edges, or a table. */
#include "program.h"

/* Groups of faces, of which a face has the last that fits, and of edges. */
enum { SOUND, OPEN, CROWDED, TURNED, DUPLICATE, FLAT, CROSSING, OF_EDGES, GROUPS = OF_EDGES + 4 };

static const char *const group_names[GROUPS] = { "sound", "open", "crowded", "turned", "duplicate", "flat",
                                                 "crossing", "crossing line", "open edge", "crowded edge",
                                                 "turned edge" };

static int kind_of(pbw_index faces)                  /* of an edge */
{
    return faces == 1 ? OPEN : faces == 2 ? TURNED : CROWDED;
}

/* ---- the report ---- */

static void list_crossings(const job *j, const pbw_surface_faults *f)
{
    size_t i;
    report_line(j, "%zu pair%s of faces meet%s elsewhere than in corners and edges of both:",
                COUNT(f->crossing_count), f->crossing_count == 1 ? "s" : "");
    for (i = 0; i < f->crossing_count && i < MOST_SHOWN; i++) {
        const double *p = f->segments + 6 * i, *q = p + 3;
        const pbw_index *face = f->crossings + 2 * i;
        if (memcmp(p, q, 3 * sizeof *p) == 0) {
            report_line(j, "  %lu and %lu at (%g, %g, %g)", (unsigned long)face[0], (unsigned long)face[1], p[0],
                        p[1], p[2]);
        } else {
            report_line(j, "  %lu and %lu from (%g, %g, %g) to (%g, %g, %g)", (unsigned long)face[0],
                        (unsigned long)face[1], p[0], p[1], p[2], q[0], q[1], q[2]);
        }
    }
}

/* Faces without area, or given again: `each` numbers in each row, of which the second is the first such face. */
static void list_faces(const job *j, const pbw_index *rows, size_t count, size_t each, const char *what)
{
    size_t i;
    report_line(j, "%zu face%s %s:", COUNT(count), what);
    for (i = 0; i < count && i < MOST_SHOWN; i++) {
        const size_t face = rows[each * i];
        const double *p = j->cloud.points + 3 * (size_t)j->cloud.triangles[3 * face];
        char as[40] = "";
        if (each == 2) {
            snprintf(as, sizeof as, " as %lu", (unsigned long)rows[2 * i + 1]);
        }
        report_line(j, "  %zu%s with a corner at (%g, %g, %g)", face, as, p[0], p[1], p[2]);
    }
}

static void tell_more(const job *j, size_t count)
{
    if (count > MOST_SHOWN) {
        report_line(j, "  and %zu more", count - MOST_SHOWN);
    }
}

static void list_faults(const job *j, const pbw_surface_faults *f)
{
    if (f->crossing_count > 0) {
        list_crossings(j, f);
        tell_more(j, f->crossing_count);
    }
    if (f->flat_count > 0) {
        list_faces(j, f->flat, f->flat_count, 1, "without area");
        tell_more(j, f->flat_count);
    }
    if (f->duplicate_count > 0) {
        list_faces(j, f->duplicates, f->duplicate_count, 2, "given again");
        tell_more(j, f->duplicate_count);
    }
}

/* ---- outputs ---- */

typedef struct sheet { const job *j; const pbw_surface_faults *f; } sheet;

static void emit_place(FILE *file, const double *p)
{
    fprintf(file, ",%.17g,%.17g,%.17g", p[0], p[1], p[2]);
}

/* A table: the fault, faces or points that have it, and its place, or where it begins and ends. */
static void emit_table(void *user, FILE *file)
{
    const pbw_surface_faults *f = ((const sheet *)user)->f;
    const pbwio_cloud *c = &((const sheet *)user)->j->cloud;
    size_t i;
    fputs("fault,face,other_face,point,other_point,x,y,z,to_x,to_y,to_z\n", file);
    for (i = 0; i < f->crossing_count; i++) {
        const pbw_index *pair = f->crossings + 2 * i;
        fprintf(file, "crossing,%lu,%lu,,", (unsigned long)pair[0], (unsigned long)pair[1]);
        emit_place(file, f->segments + 6 * i);
        emit_place(file, f->segments + 6 * i + 3);
        fputc('\n', file);
    }
    for (i = 0; i < f->flat_count; i++) {
        fprintf(file, "flat,%lu,,,", (unsigned long)f->flat[i]);
        emit_place(file, c->points + 3 * (size_t)c->triangles[3 * (size_t)f->flat[i]]);
        fputs(",,,\n", file);
    }
    for (i = 0; i < f->duplicate_count; i++) {
        const pbw_index *d = f->duplicates + 2 * i;
        fprintf(file, "duplicate,%lu,%lu,,", (unsigned long)d[0], (unsigned long)d[1]);
        emit_place(file, c->points + 3 * (size_t)c->triangles[3 * (size_t)d[0]]);
        fputs(",,,\n", file);
    }
    for (i = 0; i < f->edge_count; i++) {
        const pbw_index *e = f->edges + 2 * i;
        fprintf(file, "%s,,,%lu,%lu", group_names[OF_EDGES + kind_of(f->edge_triangles[i])], (unsigned long)e[0],
                (unsigned long)e[1]);
        emit_place(file, c->points + 3 * (size_t)e[0]);
        emit_place(file, c->points + 3 * (size_t)e[1]);
        fputc('\n', file);
    }
    for (i = 0; i < f->repeated_count; i++) {
        const pbw_index *r = f->repeated + 2 * i;
        fprintf(file, "repeated point,,,%lu,%lu", (unsigned long)r[0], (unsigned long)r[1]);
        emit_place(file, c->points + 3 * (size_t)r[0]);
        fputs(",,,\n", file);
    }
}

static int by_ends(const void *a, const void *b)
{
    const pbw_index *e = (const pbw_index *)a, *g = (const pbw_index *)b;
    return e[0] != g[0] ? (e[0] < g[0] ? -1 : 1) : e[1] < g[1] ? -1 : e[1] > g[1];
}

/* Puts the faces into groups; first: room for an index of each point. */
static void mark_faces(const pbwio_cloud *c, const pbw_surface_faults *f, pbw_index *first, pbw_index *group)
{
    size_t i;
    for (i = 0; i < c->count; i++) {
        first[i] = (pbw_index)i;
    }
    for (i = 0; i < f->repeated_count; i++) {
        first[f->repeated[2 * i]] = f->repeated[2 * i + 1];
    }
    for (i = 0; i < c->triangle_count; i++) {
        group[i] = SOUND;
    }
    for (i = 0; i < 3 * c->triangle_count && f->edge_count > 0; i++) {
        const pbw_index a = first[c->triangles[i]], b = first[c->triangles[i % 3 == 2 ? i - 2 : i + 1]];
        const pbw_index ends[2] = { a < b ? a : b, a < b ? b : a };
        const pbw_index *e = (const pbw_index *)bsearch(ends, f->edges, f->edge_count, sizeof ends, by_ends);
        if (e != NULL) {
            const pbw_index kind = (pbw_index)kind_of(f->edge_triangles[(e - f->edges) / 2]);
            group[i / 3] = kind > group[i / 3] ? kind : group[i / 3];
        }
    }
    for (i = 0; i < f->duplicate_count; i++) {
        group[f->duplicates[2 * i]] = DUPLICATE;
    }
    for (i = 0; i < f->flat_count; i++) {
        group[f->flat[i]] = FLAT;
    }
    for (i = 0; i < 2 * f->crossing_count; i++) {
        group[f->crossings[i]] = CROSSING;
    }
}

static int name_groups(pbwio_cloud *c)
{
    size_t i;
    c->groups = (pbwio_group *)calloc(GROUPS, sizeof *c->groups);
    for (i = 0; i < GROUPS && c->groups != NULL; i++) {
        pbwio_group *g = c->groups + i;
        g->dim = i < OF_EDGES ? 2 : 1;
        g->tag = (long long)(i < OF_EDGES ? i : i - OF_EDGES) + 1;
        g->name = (char *)malloc(strlen(group_names[i]) + 1);
        if (g->name == NULL) {
            return 0;
        }
        strcpy(g->name, group_names[i]);
        c->group_count++;
    }
    return c->groups != NULL;
}

/* Makes of j->cloud the surface with its faults: groups of faces, and of edges, which are faulty ones and what two
   faces have in common.  Returns 0 if there is no memory. */
static int mark_cloud(job *j, const pbw_surface_faults *f)
{
    pbwio_cloud *old = &j->cloud, c;
    const size_t points = old->count, lines = f->crossing_count;
    pbw_index *first = (pbw_index *)malloc((points + 1) * sizeof *first);
    size_t i;
    int good;
    memset(&c, 0, sizeof c);
    c.dim = 3;
    c.count = points + 2 * lines;
    c.points = (double *)malloc((3 * c.count + 1) * sizeof *c.points);
    c.segment_count = lines + f->edge_count;
    c.segments = (pbw_index *)malloc((2 * c.segment_count + 1) * sizeof *c.segments);
    c.segment_groups = (pbw_index *)malloc((c.segment_count + 1) * sizeof *c.segment_groups);
    c.triangle_groups = (pbw_index *)malloc((old->triangle_count + 1) * sizeof *c.triangle_groups);
    good = first != NULL && c.points != NULL && c.segments != NULL && c.segment_groups != NULL
        && c.triangle_groups != NULL && name_groups(&c);
    if (good) {
        mark_faces(old, f, first, c.triangle_groups);
        memcpy(c.points, old->points, 3 * points * sizeof *c.points);
        if (lines > 0) {
            memcpy(c.points + 3 * points, f->segments, 6 * lines * sizeof *c.points);
        }
        for (i = 0; i < c.segment_count; i++) {
            const int edge = i >= lines;
            c.segments[2 * i] = edge ? f->edges[2 * (i - lines)] : (pbw_index)(points + 2 * i);
            c.segments[2 * i + 1] = edge ? f->edges[2 * (i - lines) + 1] : (pbw_index)(points + 2 * i + 1);
            c.segment_groups[i] = (pbw_index)(OF_EDGES + (edge ? kind_of(f->edge_triangles[i - lines]) : 0));
        }
        c.triangles = old->triangles;
        c.triangle_count = old->triangle_count;
        old->triangles = NULL;
        pbwio_free(old);
        *old = c;
    } else {
        pbwio_free(&c);
    }
    free(first);
    return good;
}

/* The surface in groups, as .obj with its lines, which pbw_model.h does not write. */
static void emit_obj(void *user, FILE *file)
{
    const pbwio_cloud *c = &((const sheet *)user)->j->cloud;
    size_t i, g;
    for (i = 0; i < c->count; i++) {
        fprintf(file, "v %.17g %.17g %.17g\n", c->points[3 * i], c->points[3 * i + 1], c->points[3 * i + 2]);
    }
    for (g = 0; g < GROUPS; g++) {
        const int edges = g >= OF_EDGES;
        const pbw_index *group = edges ? c->segment_groups : c->triangle_groups, *item;
        int named = 0;
        for (i = 0; i < (edges ? c->segment_count : c->triangle_count); i++) {
            if (group[i] != g) {
                continue;
            }
            if (!named++) {
                fprintf(file, "g %s\n", group_names[g]);
            }
            item = edges ? c->segments + 2 * i : c->triangles + 3 * i;
            fprintf(file, "%s %lu %lu", edges ? "l" : "f", (unsigned long)item[0] + 1, (unsigned long)item[1] + 1);
            if (!edges) {
                fprintf(file, " %lu", (unsigned long)item[2] + 1);
            }
            fputc('\n', file);
        }
    }
}

/* The table, the page, or the surface in groups. */
static pbwio_status write_faults(job *j, const char *path, const char *ending, void *user, pbwio_error *error)
{
    pbwmodel_content content;
    pbwio_output output;
    if (strcmp(ending, "csv") == 0 || strcmp(ending, "obj") == 0) {
        drop_groups(j);                              /* all of them are there */
        return pbwio_save(path, strcmp(ending, "csv") == 0 ? emit_table : emit_obj, user, &j->build, error);
    }
    memset(&content, 0, sizeof content);
    fill_surface(j, &content, &output);
    j->write = output;
    if (strcmp(ending, "html") == 0) {
        return write_mesh_page(j, path, error);
    }
    content.format = PBWIO_VTU;
    return pbwmodel_write(path, &content, j->write.flags, error);
}

int check_faces(job *j)
{
    const double start = now();
    pbw_surface_faults f;
    double seconds;
    sheet s;
    int failed, closed;
    begin(j, "faults", "");
    j->stage = "faults";
    failed = explain(j, pbw_surface_crossings(j->cloud.points, j->cloud.count, j->cloud.triangles,
                                              j->cloud.triangle_count, &j->build, &f));
    j->stage = NULL;
    if (failed) {
        return failed;
    }
    seconds = now() - start;
    closed = describe_faults(j, &j->cloud, &f, 1, now());
    report_step(j, "faults", seconds, "%zu pair%s of faces that meet, %zu face%s without area, %zu given again",
                COUNT(f.crossing_count), COUNT(f.flat_count), f.duplicate_count);
    list_faults(j, &f);
    s.j = j;
    s.f = &f;
    if (j->outputs > 0) {
        failed = !mark_cloud(j, &f) ? fail(j, "out of memory") : show_faces(j);
        failed = failed ? failed : write_with(j, write_faults, &s);
    }
    closed = closed && f.crossing_count + f.flat_count + f.duplicate_count == 0;
    pbw_surface_faults_free(&f);
    return failed ? failed : closed ? 0 : fail(j, "the surface has faults");
}
