/* expression.c: the value of a formula in x, y and z, such as 0.1 + 0.2*hypot(x-1, y).  Numbers, + - * / ^, brackets,
   functions of one or two values; read again for each value, left to right, to a bounded depth. */
#include "program.h"

enum { DEEPEST = 64 };

typedef struct reader {
    const char *at, *wrong;                          /* wrong: where it is no formula; NULL = nowhere */
    const double *coordinates;
    int dim, depth;
} reader;

static double sum(reader *r);

static void skip(reader *r)
{
    for (; *r->at == ' '; r->at++) {
    }
}

static double call(reader *r, const char *name, size_t length)
{
    static const char *const names[] = { "sqrt", "abs", "exp", "log", "sin", "cos", "min", "max", "hypot", NULL };
    double a, b = 0;
    int f = 0;
    while (names[f] != NULL && (strlen(names[f]) != length || strncmp(names[f], name, length) != 0)) {
        f++;
    }
    skip(r);
    if (names[f] == NULL || *r->at != '(') {
        r->wrong = name;
        return 0;
    }
    r->at++;
    a = sum(r);
    skip(r);
    if (f >= 6 && *r->at == ',') {
        r->at++;
        b = sum(r);
        skip(r);
    } else if (f >= 6) {
        r->wrong = r->at;
    }
    if (*r->at != ')') {
        r->wrong = r->at;
        return 0;
    }
    r->at++;
    switch (f) {
        case 0: return sqrt(a);
        case 1: return fabs(a);
        case 2: return exp(a);
        case 3: return log(a);
        case 4: return sin(a);
        case 5: return cos(a);
        case 6: return a < b ? a : b;
        case 7: return a > b ? a : b;
        default: return hypot(a, b);
    }
}

static double atom(reader *r)
{
    const char *start;
    char *end;
    double value;
    skip(r);
    start = r->at;
    if (*r->at == '(') {
        r->at++;
        value = sum(r);
        skip(r);
        r->wrong = *r->at == ')' || r->wrong != NULL ? r->wrong : r->at;
        r->at += *r->at == ')';
        return value;
    }
    if ((*r->at >= '0' && *r->at <= '9') || *r->at == '.') {
        value = strtod(r->at, &end);
        r->wrong = end == r->at ? r->at : r->wrong;
        r->at = end;
        return value;
    }
    while (*r->at >= 'a' && *r->at <= 'z') {
        r->at++;
    }
    if (r->at - start == 1 && *start >= 'x' && *start < 'x' + r->dim) {
        return r->coordinates[*start - 'x'];
    }
    return call(r, start, (size_t)(r->at - start));
}

static double power(reader *r)
{
    double value;
    skip(r);
    if (++r->depth > DEEPEST || r->wrong != NULL) {
        r->wrong = r->wrong != NULL ? r->wrong : r->at;
        return 0;
    }
    if (*r->at == '-') {
        r->at++;
        value = -power(r);
    } else {
        value = atom(r);
        skip(r);
        if (*r->at == '^') {
            r->at++;
            value = pow(value, power(r));
        }
    }
    r->depth--;
    return value;
}

static double product(reader *r)
{
    double value = power(r);
    for (skip(r); (*r->at == '*' || *r->at == '/') && r->wrong == NULL; skip(r)) {
        const char sign = *r->at++;
        const double next = power(r);
        value = sign == '*' ? value * next : value / next;
    }
    return value;
}

static double sum(reader *r)
{
    double value = product(r);
    for (skip(r); (*r->at == '+' || *r->at == '-') && r->wrong == NULL; skip(r)) {
        const char sign = *r->at++;
        const double next = product(r);
        value = sign == '+' ? value + next : value - next;
    }
    return value;
}

double evaluate(const char *formula, int dim, const double *at, const char **wrong)
{
    reader r;
    double value;
    memset(&r, 0, sizeof r);
    r.at = formula;
    r.coordinates = at;
    r.dim = dim;
    value = sum(&r);
    skip(&r);
    *wrong = r.wrong != NULL ? r.wrong : *r.at != 0 ? r.at : NULL;
    return value;
}
