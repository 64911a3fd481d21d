/* shares.c: how many points get in at once, by four threads that own cells of the plane, pieces of a Hilbert curve.
   cc -O2 -I. examples/shares.c -o shares -lpthread -lm
   shares shares.svg also draws it, three pictures in one file.  Prints expected/shares.txt. */
#include "steps.h"

enum { THREADS = 4 };
static int thread[COUNT], last = 1;                 /* that tried to insert it; the number of the last point */

/* A thread inserts a point if all corners of the cavity are in its cells; it takes those that are nobody's.  Cavities
   of two threads then have no corner in common, and each stays what it is whatever the other does. */
static int insert(int i, int me)
{
    int mine = 1;
    locate(points[i]);
    for (int k = 0; k < 3 * carved; k++) {
        int *cell = owner + mesh.simplices[3 * cavity[k / 3] + (pbw_index)k % 3] / CELL;
        *cell = *cell == NOBODY ? me : *cell;
        mine &= *cell == me;
    }
    thread[i] = me;
    inserted[i] = mine ? ++last : 0;
    return mine;
}

/* Each thread goes through its share of what is left, all at the same pace.  Returns how many points they leave. */
static int insert_round(int number, int threads)
{
    int left[COUNT], count = 0, done = 0;
    for (int i = 0; i < COUNT; i++) {
        left[count] = i;
        count += !inserted[i];
    }
    for (int step = 0; step * threads < count; step++) {
        int before = last;
        memset(owner, NOBODY, sizeof owner);
        for (int me = 1; me <= threads; me++) {
            int at = count * (me - 1) / threads + step;
            done += at < count * me / threads && insert(left[at], me);
        }
        if (number == 1 && (step == count / threads * 3 / 10 || step == count / threads * 8 / 10)) {
            picture(step < count / threads / 2 ? "1  Four threads: a point takes the cells that it needs"
                                               : "2  Further on: black points met another thread's");
            for (int i = 0; i < count; i++) {
                int v = left[i];
                if (inserted[v] > before) {
                    locate(points[v]);
                    for (int k = 0; k < carved; k++) {
                        triangle(cavity[k], colours[thread[v]], 0.6);
                    }
                    circle(points[v], 5, colours[thread[v]], "#fff");
                } else if (!inserted[v]) {
                    circle(points[v], thread[v] == NOBODY ? 2.2 : 4, thread[v] == NOBODY ? "#fff" : "#101828",
                           "#101828");
                }
            }
        }
        triangulate();
    }
    printf("round %d: %d points by %d thread%s, %d left\n", number, done, threads, threads > 1 ? "s" : "",
           count - done);
    return count - done;
}

int main(int argc, char **argv)
{
    begin_pictures(argc, argv);
    scatter();
    begin_with(4);
    for (int round = 1, left = COUNT; left > 0; round++) {
        left = insert_round(round, left > 8 * THREADS ? THREADS : 1);
    }
    memset(owner, NOBODY, sizeof owner);
    picture("3  Done: which thread made each triangle");
    for (pbw_index t = 0; t < mesh.simplex_count; t++) {
        const pbw_index *c = mesh.simplices + 3 * t;
        pbw_index v = inserted[c[1]] > inserted[c[0]] ? c[1] : c[0];
        triangle(t, colours[thread[inserted[c[2]] > inserted[v] ? c[2] : v]], 0.5);
    }
    return end_pictures(argc, argv);
}
