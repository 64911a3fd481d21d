/* sizes.c: --size, in the plane and in space, and --alpha: a number, a formula of the place, or a column.
   In: the option; the input, whose weights are the column's values.  Out: sizes at places. */
#include "program.h"

enum { PER_SIDE = 17 };                               /* places a side of the box where a formula is looked at */
static const double growth = 0.3;                    /* of a column's sizes, per distance from the surface */

const char *size_column(const char *size)
{
    static const double middle[3] = { 0.1, 0.1, 0.1 };
    const char *wrong = NULL;
    size_t i;
    if (size == NULL) {
        return NULL;
    }
    (void)evaluate(size, 3, middle, &wrong);
    i = size[0] == '#' ? 1 + strspn(size + 1, "0123456789")
      : strspn(size, "_0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz");
    return wrong != NULL && size[i] == 0 && (size[0] < '0' || size[0] > '9') ? size : NULL;
}

int check_sizes(const job *j, const char *name, int dim)
{
    static const double middle[3] = { 0.1, 0.1, 0.1 };
    const char *size = text_of(j, name), *wrong = NULL;
    if (size != NULL && size_column(size) == NULL) {
        (void)evaluate(size, dim, middle, &wrong);
    }
    return wrong != NULL ? complain("%s %s: this is no formula from \"%s\" on", name, size, wrong) : 0;
}

int load_sizes(job *j, const char *name, int flat)
{
    const char *column = size_column(text_of(j, name));
    int status = check_sizes(j, name, 3);
    size_t i;
    if (status != 0) {
        return status;
    }
    j->read.weight = column != NULL && column[0] == '#' ? column + 1 : column;
    status = load(j, flat);
    for (i = 0; status == 0 && column != NULL && i < j->cloud.count; i++) {
        if (!(j->cloud.weights[i] > 0)) {
            status = fail(j, "%s: %s %s: it is %g at point %zu, a number above 0 is needed", j->input, name,
                          column, j->cloud.weights[i], i + (size_t)j->cloud.base);
        }
    }
    return status;
}

double size_at_point(const job *j, size_t point)
{
    const char *size = text_of(j, "--size"), *wrong;
    return j->cloud.weights != NULL ? j->cloud.weights[point]
         : size != NULL ? evaluate(size, 3, j->cloud.points + 3 * point, &wrong) : 1;
}

/* ---- in the space around a surface ---- */

static double size_in_space(void *user, const double p[3])
{
    const sizing *s = (const sizing *)user;
    const pbw_surface *surface = &s->surface;
    const char *wrong;
    double place[3], n[3][3], sum = 0, size = 0;
    pbw_index t;
    int i, k;
    if (s->formula != NULL) {
        size = evaluate(s->formula, 3, p, &wrong);
        return size > 0 ? fmin(size, s->most) : s->most;
    }
    t = pbw_surface_closest(surface, p, HUGE_VAL, place);
    for (i = 0; i < 3; i++) {                        /* weights of corners: areas of the triangles across from them */
        const double *a = surface->points + 3 * (size_t)surface->triangles[3 * (size_t)t + (size_t)(i + 1) % 3];
        const double *b = surface->points + 3 * (size_t)surface->triangles[3 * (size_t)t + (size_t)(i + 2) % 3];
        for (k = 0; k < 3; k++) {
            const int u = (k + 1) % 3, v = (k + 2) % 3;
            n[i][k] = (a[u] - place[u]) * (b[v] - place[v]) - (a[v] - place[v]) * (b[u] - place[u]);
        }
        n[i][0] = sqrt(n[i][0] * n[i][0] + n[i][1] * n[i][1] + n[i][2] * n[i][2]);
        sum += n[i][0];
    }
    for (i = 0; i < 3; i++) {
        size += s->values[surface->triangles[3 * (size_t)t + (size_t)i]] * (sum > 0 ? n[i][0] / sum : 1.0 / 3);
    }
    return size + growth * sqrt(pow(p[0] - place[0], 2) + pow(p[1] - place[1], 2) + pow(p[2] - place[2], 2));
}

static void stretch(sizing *s, double size)
{
    if (size > 0 && size <= DBL_MAX) {
        s->most = fmax(s->most, size);
        s->least = s->least > 0 ? fmin(s->least, size) : size;
    }
}

/* The range of a formula, on a lattice in the box of the points and at them. */
static void look_at_formula(const pbwio_cloud *c, sizing *s, const double low[3], const double high[3])
{
    const char *wrong;
    size_t i;
    int k;
    for (i = 0; i < PER_SIDE * PER_SIDE * PER_SIDE; i++) {
        const size_t at[3] = { i % PER_SIDE, i / PER_SIDE % PER_SIDE, i / PER_SIDE / PER_SIDE };
        double p[3];
        for (k = 0; k < 3; k++) {
            p[k] = low[k] + (high[k] - low[k]) * (double)at[k] / (PER_SIDE - 1);
        }
        stretch(s, evaluate(s->formula, 3, p, &wrong));
    }
    for (i = 0; i < c->count; i++) {
        stretch(s, evaluate(s->formula, 3, c->points + 3 * i, &wrong));
    }
}

/* Fills the range, and what size_in_space needs, of an option that is no number: from values of points where there
   are some, that of the nearest point where there are no faces.  *diagonal: of the points' box. */
static int set_range(job *j, const char *name, sizing *s, double *diagonal)
{
    const pbwio_cloud *c = &j->cloud;
    const char *size = text_of(j, name);
    double low[3] = { HUGE_VAL, HUGE_VAL, HUGE_VAL }, high[3] = { -HUGE_VAL, -HUGE_VAL, -HUGE_VAL };
    size_t i;
    for (i = 0; i < 3 * c->count; i++) {
        low[i % 3] = fmin(low[i % 3], c->points[i]);
        high[i % 3] = fmax(high[i % 3], c->points[i]);
    }
    s->formula = c->weights == NULL ? size : NULL;
    s->values = c->weights;
    if (s->formula != NULL) {
        look_at_formula(c, s, low, high);
    }
    for (i = 0; s->values != NULL && i < c->count; i++) {
        stretch(s, s->values[i]);
    }
    if (!(s->most > 0)) {
        return fail(j, "%s %s: it is above 0 nowhere in the box of %s", name, size, j->input);
    }
    *diagonal = sqrt(pow(high[0] - low[0], 2) + pow(high[1] - low[1], 2) + pow(high[2] - low[2], 2));
    if (s->values != NULL && c->triangle_count == 0) {
        s->corners = (pbw_index *)malloc((3 * c->count + 1) * sizeof *s->corners);
        for (i = 0; i < 3 * c->count && s->corners != NULL; i++) {
            s->corners[i] = (pbw_index)(i / 3);
        }
    }
    return s->values == NULL ? 0
         : c->triangle_count == 0 && s->corners == NULL ? fail(j, "out of memory")
         : explain(j, pbw_surface_create(c->points, c->count, s->corners != NULL ? s->corners : c->triangles,
                                         s->corners != NULL ? c->count : c->triangle_count, &j->build, &s->surface));
}

/* Returns whether an option is a number, or not given: *number, then 0. */
static int is_number(const job *j, const char *name, double *number)
{
    const char *text = text_of(j, name);
    char *end = NULL;
    *number = text != NULL ? strtod(text, &end) : 0;
    return text == NULL || (*number > 0 && *end == 0);
}

int set_sizes(job *j, sizing *s, pbw_solid_options *how)
{
    double diagonal;
    int failed;
    memset(s, 0, sizeof *s);
    if (is_number(j, "--size", &how->size)) {
        return 0;
    }
    failed = set_range(j, "--size", s, &diagonal);
    if (!failed) {
        s->most = fmin(s->most, diagonal / 10);
        how->size = s->most;
        how->least_size = how->least_size > 0 ? how->least_size : fmin(s->least, s->most);
        how->size_at = size_in_space;
        how->size_user = s;
    }
    return failed;
}

int set_alphas(job *j, sizing *s, pbw_wrap_options *how)
{
    double diagonal;
    int failed;
    memset(s, 0, sizeof *s);
    if (is_number(j, "--alpha", &how->alpha)) {
        return 0;
    }
    failed = set_range(j, "--alpha", s, &diagonal);
    how->alpha = s->most;
    how->offset = s->least / 30;
    how->alpha_at = size_in_space;
    how->alpha_user = s;
    return failed;
}

void free_sizes(sizing *s)
{
    pbw_surface_free(&s->surface);
    free(s->corners);
}
