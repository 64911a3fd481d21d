/* geojson.c: reads GeoJSON (RFC 7946) as a plane domain.
   In: the text.  Out: points, segments, features, heights.  Holds: no call recurses; each byte is read a bounded
   number of times, whatever the order of members.

   Points of Point and MultiPoint are points; lines are segments; rings of polygons are segments with the inside on
   the left.  Features are counted from 0 here, from 1 in messages and tags. */
#include "domain.h"

enum { DEEPEST = 64, COLLECTIONS = 16 };             /* brackets; collections in collections */

typedef struct place { char *at; size_t line; } place;               /* at NULL: nothing is there */

typedef struct reader {
    text *t;
    plan *d;
    const char *region_by;                           /* the property that names regions; NULL: the feature's number */
    label *labels;                                   /* one a feature */
    size_t ring;                                     /* of the polygon at hand */
    pbw_index feature;                               /* at hand; PBW_NONE: a geometry of none */
    size_t positions, heights, longer;               /* of all, of those with a height, of those with more numbers */
    size_t unclosed, empty, nameless;                /* rings; features without a geometry, without the property */
    size_t line, unclosed_line;                      /* where the list at hand, the first unclosed ring begins */
    char properties[128];                            /* the names of those of the first feature */
} reader;

/* ---- JSON ---- */

static void skip_space(text *t)
{
    for (; *t->at != 0 && strchr(" \t\r\n", *t->at) != NULL; t->at++) {
        t->line += *t->at == '\n';
    }
}

/* Moves behind the string at t->at. */
static int skip_string(text *t)
{
    if (*t->at != '"') {
        return refuse(t, "a string is needed");
    }
    for (t->at++; *t->at != '"'; t->at++) {
        t->at += *t->at == '\\';
        if ((unsigned char)*t->at < ' ') {
            return refuse(t, "a string does not end");
        }
    }
    t->at++;
    return 1;
}

/* Moves behind the value at t->at, whatever it is. */
static int skip_value(text *t)
{
    char kind[DEEPEST];
    int depth = 0;
    do {
        skip_space(t);
        if (*t->at == '"') {
            if (!skip_string(t)) {
                return 0;
            }
        } else if (*t->at == '{' || *t->at == '[') {
            if (depth == DEEPEST) {
                return refuse(t, "brackets more than %d deep", DEEPEST);
            }
            kind[depth++] = *t->at++ == '{' ? '}' : ']';
        } else if (*t->at == '}' || *t->at == ']') {
            if (depth == 0 || kind[--depth] != *t->at) {
                return refuse(t, "\"%c\" closes nothing", *t->at);
            }
            t->at++;
        } else if (depth > 0 && (*t->at == ',' || *t->at == ':')) {
            t->at++;
        } else {
            const size_t length = strcspn(t->at, " \t\r\n,:{}[]\"");
            if (length == 0) {
                return refuse(t, *t->at == 0 ? "the file ends inside of brackets" : "a value is needed");
            }
            t->at += length;
        }
    } while (depth > 0);
    return 1;
}

/* The hexadecimal digits of \uXXXX; -1: they are none. */
static long code_unit(const char *s)
{
    char digits[5];
    snprintf(digits, sizeof digits, "%.4s", s);
    return strspn(digits, "0123456789abcdefABCDEF") == 4 ? strtol(digits, NULL, 16) : -1;
}

/* The next character of a string, decoded: its bytes in UTF-8; returns their number, 0 at the end of the string. */
static size_t next_character(const char **s, char out[4])
{
    static const char escapes[] = "\"\\/bfnrt", means[] = "\"\\/\b\f\n\r\t";
    const char *found;
    long code, low;
    if (**s == '"') {
        return 0;
    }
    if (**s != '\\') {
        out[0] = *(*s)++;
        return 1;
    }
    found = strchr(escapes, *++*s);
    code = **s == 'u' ? code_unit(*s + 1) : -1;
    if (code < 0) {
        out[0] = found != NULL ? means[found - escapes] : **s;
        ++*s;
        return 1;
    }
    *s += 5;
    if (code >= 0xd800 && code < 0xdc00 && (*s)[0] == '\\' && (*s)[1] == 'u') {
        low = code_unit(*s + 2);
        if (low >= 0xdc00 && low < 0xe000) {
            code = 0x10000 + ((code - 0xd800) << 10) + (low - 0xdc00);
            *s += 6;
        }
    }
    if (code < 0x80) {
        out[0] = (char)code;
        return 1;
    }
    if (code < 0x800) {
        out[0] = (char)(0xc0 | code >> 6);
        out[1] = (char)(0x80 | (code & 63));
        return 2;
    }
    if (code < 0x10000) {
        out[0] = (char)(0xe0 | code >> 12);
        out[1] = (char)(0x80 | (code >> 6 & 63));
        out[2] = (char)(0x80 | (code & 63));
        return 3;
    }
    out[0] = (char)(0xf0 | code >> 18);
    out[1] = (char)(0x80 | (code >> 12 & 63));
    out[2] = (char)(0x80 | (code >> 6 & 63));
    out[3] = (char)(0x80 | (code & 63));
    return 4;
}

/* Whether the string at a place is a word. */
static int is_string(const char *at, const char *word)
{
    char bytes[4];
    size_t size;
    if (at == NULL || *at++ != '"') {
        return 0;
    }
    while ((size = next_character(&at, bytes)) > 0) {
        if (bytes[0] == 0 || strncmp(word, bytes, size) != 0) {
            return 0;
        }
        word += size;
    }
    return *word == 0;
}

/* The text of a string, decoded, in a new block; NULL: out of memory. */
static char *string_at(const char *at)
{
    const char *end = ++at;
    char *copy, *out;
    char bytes[4];
    size_t size;
    for (; *end != '"'; end++) {
        end += *end == '\\';
    }
    out = copy = (char *)malloc((size_t)(end - at) + 1);
    while (copy != NULL && (size = next_character(&at, bytes)) > 0) {
        memcpy(out, bytes, size);
        out += size;
    }
    if (copy != NULL) {
        *out = 0;
    }
    return copy;
}

/* Moves to the next element of an array or the next key of an object that t->at is in; first: 1 before the first one.
   Returns 0 behind the closing bracket, or after a failure. */
static int next_element(text *t, int *first, char bracket)
{
    skip_space(t);
    if (*t->at == bracket) {
        t->at++;
        return 0;
    }
    if (!*first && *t->at++ != ',') {
        t->at--;
        return refuse(t, "a comma or \"%c\" is needed", bracket);
    }
    *first = 0;
    skip_space(t);
    return t->error[0] == 0;
}

/* Moves behind the object at t->at, and finds the values of its members by name; of two with one name the last
   counts.  names: NULL ends them. */
static int read_members(text *t, const char *const *names, place *found)
{
    int first = 1, k;
    for (k = 0; names[k] != NULL; k++) {
        found[k].at = NULL;
    }
    if (*t->at != '{') {
        return refuse(t, "an object is needed");
    }
    t->at++;
    while (next_element(t, &first, '}')) {
        const char *key = t->at;
        if (!skip_string(t)) {
            return 0;
        }
        skip_space(t);
        if (*t->at++ != ':') {
            t->at--;
            return refuse(t, "\":\" is needed");
        }
        skip_space(t);
        for (k = 0; names[k] != NULL; k++) {
            if (is_string(key, names[k])) {
                found[k].at = t->at;
                found[k].line = t->line;
            }
        }
        if (!skip_value(t)) {
            return 0;
        }
    }
    return t->error[0] == 0;
}

static void go_to(text *t, place where)
{
    t->at = where.at;
    t->line = where.line;
}

static place here(const text *t)
{
    place where;
    where.at = t->at;
    where.line = t->line;
    return where;
}

/* ---- coordinates ---- */

/* Reads a position: x, y, and a height if there is a third number. */
static int read_position(reader *r)
{
    text *t = r->t;
    double x[3] = { 0, 0, 0 }, unused;
    int n = 0, first = 1;
    if (*t->at != '[') {
        return refuse(t, "a position [x, y] is needed");
    }
    t->at++;
    while (next_element(t, &first, ']')) {
        if (!next_number(t, n < 3 ? x + n : &unused)) {
            return refuse(t, "a finite number is needed");
        }
        n++;
    }
    if (n < 2) {
        return refuse(t, "a position [x, y] is needed");
    }
    if (!grow((void **)&r->d->heights, r->d->point_count, sizeof(double))) {
        return refuse(t, "out of memory");
    }
    r->d->heights[r->d->point_count] = x[2];
    r->positions++;
    r->heights += n > 2;
    r->longer += n > 3;
    return t->error[0] == 0 && (append_point(r->d, x[0], x[1]) || refuse(t, "out of memory"));
}

static int are_equal(const double *a, const double *b)
{
    return !(a[0] < b[0] || a[0] > b[0] || a[1] < b[1] || a[1] > b[1]);
}

/* Which way a ring turns: at its lowest corner, which is convex.  1: counter-clockwise; 0: its area is 0 there. */
static int turn_of(const double *x, size_t n)
{
    size_t i, low = 0, before, after;
    for (i = 1; i < n; i++) {
        if (x[2 * i] < x[2 * low] || (!(x[2 * i] > x[2 * low]) && x[2 * i + 1] < x[2 * low + 1])) {
            low = i;
        }
    }
    for (before = (low + n - 1) % n; before != low && are_equal(x + 2 * before, x + 2 * low);
         before = (before + n - 1) % n) {
    }
    for (after = (low + 1) % n; after != low && are_equal(x + 2 * after, x + 2 * low); after = (after + 1) % n) {
    }
    return pbw_orient2(x + 2 * before, x + 2 * low, x + 2 * after);
}

/* Ends a line or ring that began with point `first`: its segments.  The first ring of a polygon is around it, the
   others are around its holes. */
static int end_line(reader *r, size_t first, int ring)
{
    plan *d = r->d;
    const double *x = d->points + 2 * first;
    size_t n = d->point_count - first, i;
    const int closed = n > 2 && are_equal(x, x + 2 * (n - 1));
    int backwards = 0;
    source from;
    from.line = r->line;
    from.feature = r->feature;
    from.marker = 0;
    from.kind = ring ? RING : closed ? CLOSED_LINE : OPEN_LINE;
    d->point_count -= (size_t)closed;
    n -= (size_t)closed;
    if (ring ? n < 3 : n < 2) {
        return refuse(r->t, ring ? "a ring of %zu corner%s" : "a line of %zu position%s", COUNT(n));
    }
    if (ring) {
        r->unclosed_line = !closed && r->unclosed++ == 0 ? from.line : r->unclosed_line;
        backwards = turn_of(x, n) * (r->ring++ == 0 ? 1 : -1) < 0;
    }
    d->line_count += !ring;
    for (i = 0; i < n - (size_t)(from.kind == OPEN_LINE); i++) {
        const size_t a = first + i, b = i + 1 < n ? a + 1 : first;
        if (!append_segment(d, backwards ? b : a, backwards ? a : b, from)) {
            return refuse(r->t, "out of memory");
        }
    }
    return 1;
}

typedef struct geometry { const char *type; int depth, lines, rings; } geometry;     /* depth: of lists in lists */

/* Reads the coordinates of a geometry, of lists so many deep; 0: a position. */
static int read_lists(reader *r, const geometry *g)
{
    text *t = r->t;
    size_t first = r->d->point_count;
    int fresh[4] = { 1, 1, 1, 1 }, depth = 0;
    if (g->depth == 0) {
        return read_position(r);
    }
    r->ring = 0;
    r->line = t->line;
    do {
        if (fresh[depth] == 1 && *t->at++ != '[') {
            t->at--;
            return refuse(t, "\"coordinates\" of a %s are lists, %d deep, of positions", g->type, g->depth);
        }
        if (!next_element(t, fresh + depth, ']')) {
            if (t->error[0] != 0) {
                return 0;
            }
            if (depth == g->depth - 1 && g->lines && r->d->point_count > first && !end_line(r, first, g->rings)) {
                return 0;
            }
            depth--;
        } else if (depth < g->depth - 1) {
            r->ring = depth + 2 < g->depth ? 0 : r->ring;
            first = r->d->point_count;
            r->line = t->line;
            fresh[++depth] = 1;
        } else if (!read_position(r)) {
            return 0;
        }
    } while (depth >= 0);
    return 1;
}

static int read_simple(reader *r, place type, place coordinates)
{
    static const geometry geometries[] = { { "Point", 0, 0, 0 }, { "MultiPoint", 1, 0, 0 }, { "LineString", 1, 1, 0 },
                                           { "MultiLineString", 2, 1, 0 }, { "Polygon", 2, 1, 1 },
                                           { "MultiPolygon", 3, 1, 1 } };
    size_t i;
    for (i = 0; i < sizeof geometries / sizeof *geometries; i++) {
        if (is_string(type.at, geometries[i].type)) {
            const size_t before = r->d->segment_count;
            int done;
            if (coordinates.at == NULL) {
                return refuse(r->t, "a %s without \"coordinates\"", geometries[i].type);
            }
            go_to(r->t, coordinates);
            done = read_lists(r, geometries + i);
            r->d->polygon_count += geometries[i].rings && r->d->segment_count > before;
            return done;
        }
    }
    if (type.at == NULL) {
        return refuse(r->t, "a geometry without a \"type\"");
    }
    go_to(r->t, type);
    return refuse(r->t, "%.*s is no type of a geometry", (int)strcspn(type.at, ",}\r\n") % 40, type.at);
}

/* Reads the geometry at t->at, and those in it if it is a collection. */
static int read_geometry(reader *r)
{
    static const char *const names[] = { "type", "coordinates", "geometries", NULL };
    text *t = r->t;
    place found[3], cursor[COLLECTIONS];
    int fresh[COLLECTIONS], depth = 0;
    do {
        if (!read_members(t, names, found)) {
            return 0;
        }
        if (is_string(found[0].at, "GeometryCollection")) {
            if (depth == COLLECTIONS) {
                return refuse(t, "collections in collections, more than %d deep", COLLECTIONS);
            }
            if (found[2].at == NULL || *found[2].at != '[') {
                return refuse(t, "a GeometryCollection without a list of \"geometries\"");
            }
            cursor[depth++] = here(t);
            go_to(t, found[2]);
            t->at++;
            fresh[depth - 1] = 1;
        } else {
            const place end = here(t);
            if (!read_simple(r, found[0], found[1])) {
                return 0;
            }
            go_to(t, end);
        }
        while (depth > 0 && !next_element(t, fresh + depth - 1, ']')) {
            if (t->error[0] != 0) {
                return 0;
            }
            go_to(t, cursor[--depth]);
        }
    } while (depth > 0);
    return 1;
}

/* ---- features ---- */

/* The names of properties, for messages. */
static void list_properties(reader *r, place properties)
{
    text *t = r->t;
    const place back = here(t);
    int first = 1;
    go_to(t, properties);
    t->at += *t->at == '{';
    while (*properties.at == '{' && strlen(r->properties) < sizeof r->properties - 40
           && next_element(t, &first, '}')) {
        const char *key = t->at;
        (void)skip_string(t);
        snprintf(r->properties + strlen(r->properties), 36, "%s%.*s", r->properties[0] == 0 ? "" : ", ",
                 t->at - key < 32 ? (int)(t->at - key) : 32, key);
        skip_space(t);
        t->at++;
        (void)skip_value(t);
    }
    go_to(t, back);
}

/* What names the regions of a feature: a property, or its number. */
static int name_regions(reader *r, place properties, label *of)
{
    const char *names[2] = { NULL, NULL };
    const place back = here(r->t);
    place value;
    double x;
    char number[40];
    memset(of, 0, sizeof *of);
    if (r->region_by == NULL) {
        of->is = 1;
        of->tag = (long long)r->feature + 1;
        return 1;
    }
    names[0] = r->region_by;
    value.at = NULL;
    if (properties.at != NULL && *properties.at == '{') {
        go_to(r->t, properties);
        if (!read_members(r->t, names, &value)) {
            return 0;
        }
        if (r->properties[0] == 0) {
            list_properties(r, properties);
        }
    }
    if (value.at == NULL || strncmp(value.at, "null", 4) == 0) {
        r->nameless++;
    } else if (*value.at == '{' || *value.at == '[') {
        go_to(r->t, value);
        return refuse(r->t, "the property \"%.40s\" names regions by a number or a string", r->region_by);
    } else {
        of->is = 1;
        go_to(r->t, value);
        if (next_number(r->t, &x) && fabs(x) < 9e15 && x <= floor(x)) {
            of->tag = (long long)x;
        } else if (*value.at == '"') {
            of->name = string_at(value.at);
        } else {
            const int length = (int)strcspn(value.at, " \t\r\n,}");
            snprintf(number, sizeof number, "%.*s", length < 32 ? length : 32, value.at);
            of->name = (char *)malloc(sizeof number);
            of->name = of->name != NULL ? strcpy(of->name, number) : NULL;
        }
        if (*value.at == '"' && of->name == NULL) {
            return refuse(r->t, "out of memory");
        }
    }
    go_to(r->t, back);
    return 1;
}

/* Reads the feature at t->at. */
static int read_feature(reader *r)
{
    static const char *const names[] = { "type", "geometry", "properties", NULL };
    text *t = r->t;
    place found[3], end;
    r->feature = (pbw_index)r->d->feature_count;
    if (!read_members(t, names, found)) {
        return 0;
    }
    end = here(t);
    if (!is_string(found[0].at, "Feature")) {
        return refuse(t, "\"features\" has something that is no Feature");
    }
    if (!grow((void **)&r->labels, r->d->feature_count, sizeof *r->labels)) {
        return refuse(t, "out of memory");
    }
    if (!name_regions(r, found[2], r->labels + r->d->feature_count)) {
        return 0;
    }
    r->d->feature_count++;
    if (found[1].at == NULL || strncmp(found[1].at, "null", 4) == 0) {
        r->empty++;
    } else {
        go_to(t, found[1]);
        if (!read_geometry(r)) {
            return 0;
        }
    }
    go_to(t, end);
    return 1;
}

/* Reads the object at t->at: features, a feature, or a geometry. */
static int read_object(reader *r)
{
    static const char *const names[] = { "type", "features", NULL };
    text *t = r->t;
    const place start = here(t);
    place found[2], end;
    int first = 1;
    if (!read_members(t, names, found)) {
        return 0;
    }
    end = here(t);
    if (found[0].at == NULL) {
        go_to(t, start);
        return refuse(t, "an object of GeoJSON with its \"type\" is needed");
    }
    if (is_string(found[0].at, "FeatureCollection")) {
        if (found[1].at == NULL || *found[1].at != '[') {
            return refuse(t, "a FeatureCollection without a list of \"features\"");
        }
        go_to(t, found[1]);
        t->at++;
        while (next_element(t, &first, ']')) {
            if (!read_feature(r)) {
                return 0;
            }
        }
        if (t->error[0] != 0) {
            return 0;
        }
    } else {
        go_to(t, start);
        r->feature = PBW_NONE;
        if (!(is_string(found[0].at, "Feature") ? read_feature(r) : read_geometry(r))) {
            return 0;
        }
    }
    go_to(t, end);
    return 1;
}

/* What is left out or mended, in words. */
static void warn_of(const job *j, const reader *r)
{
    const plan *d = r->d;
    if (r->unclosed > 0) {
        warn(j, "%s: %zu ring%s did not end where %s began, and %s closed; the first begins in line %zu", j->input,
             COUNT(r->unclosed), r->unclosed == 1 ? "it" : "they", r->unclosed == 1 ? "is" : "are", r->unclosed_line);
    }
    if (r->heights > 0 && d->heights == NULL) {
        warn(j, "%s: heights are left out: %zu of %zu positions have one", j->input, r->heights, r->positions);
    }
    if (r->longer > 0) {
        warn(j, "%s: of %zu position%s numbers beyond the third are left out", j->input, COUNT(r->longer));
    }
    if (r->empty > 0) {
        warn(j, "%s: %zu feature%s without a geometry", j->input, COUNT(r->empty));
    }
    if (r->nameless > 0) {
        warn(j, "%s: %zu feature%s without the property \"%s\": their regions are in no group", j->input,
             COUNT(r->nameless), r->region_by);
    }
    if (d->line_count > 0 && d->polygon_count == 0 && !is_given(j, "--rule")) {
        report_line(j, "lines without polygons: the domain is the hull of all points; --rule even-odd takes closed "
                    "lines for outlines, --rule seeds what lines enclose together");
    }
}

/* The groups of features: by the property, or one a feature. */
static int group_features(reader *r)
{
    plan *d = r->d;
    size_t i;
    if (r->nameless > 0 && r->nameless == d->feature_count) {
        return refuse(r->t, "no feature has a property \"%.40s\"%s%s", r->region_by, r->properties[0] == 0 ? ""
                      : "; the first has ", r->properties);
    }
    if (d->feature_count > 0 && !make_groups(d, r->labels, d->feature_count, &d->feature_groups)) {
        return refuse(r->t, "out of memory");
    }
    for (i = 0; r->region_by == NULL && i < d->group_count; i++) {
        d->groups[i].name = (char *)malloc(40);
        if (d->groups[i].name == NULL) {
            return refuse(r->t, "out of memory");
        }
        snprintf(d->groups[i].name, 40, "feature_%lld", d->groups[i].tag);
    }
    return 1;
}

int read_geojson(job *j, text *t, plan *d)
{
    reader r;
    size_t i, read = 0;
    int ok = 1;
    memset(&r, 0, sizeof r);
    r.t = t;
    r.d = d;
    r.feature = PBW_NONE;
    r.region_by = text_of(j, "--region-by");
    skip_space(t);
    while (ok && *t->at != 0) {                      /* more than one: a file of a feature a line */
        ok = read_object(&r);
        skip_space(t);
        read++;
    }
    if (!ok && r.feature != PBW_NONE && strlen(t->error) < sizeof t->error - 40) {
        sprintf(t->error + strlen(t->error), ", in feature %lu", (unsigned long)r.feature + 1);
    }
    if (ok && d->point_count == 0) {
        ok = refuse(t, read == 0 ? "the file is empty" : "there is no geometry with coordinates");
    }
    ok = ok && group_features(&r);
    if (ok && r.heights < r.positions) {
        free(d->heights);
        d->heights = NULL;
    }
    if (ok) {
        warn_of(j, &r);
    }
    for (i = 0; r.labels != NULL && i < d->feature_count; i++) {
        free(r.labels[i].name);
    }
    free(r.labels);
    return ok;
}
