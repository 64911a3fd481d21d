/* pbw.c: samples models, triangulates points, checks, writes, shows and measures.
   cc -O2 -I. -Iexamples/lib examples/program/[a-z]*.c -o pbw -lpthread -lm
   ./pbw model.obj -o model.vtu -o model.html;  ./pbw help lists the commands. */
#include "program.h"
#include <errno.h>
#include <fcntl.h>
#ifdef _WIN32
#include <io.h>
#define isatty _isatty
#else
#include <unistd.h>
#endif

static int on_progress(void *user, pbw_stage stage, double done)
{
    static const char *const names[] = { "order", "build", "output", "check" };
    const job *j = (const job *)user;
    return draw_bar(j, stage < PBW_STAGE_WORK ? names[stage] : j->stage != NULL ? j->stage : j->command->name, done);
}

/* What was printed must have arrived. */
static int end_report(const job *j, int status)
{
    errno = 0;
    if ((fflush(stdout) == 0 && !ferror(stdout)) || (status != 0 && j->report != stdout)) {
        return status;                               /* or an output went there, and its failure is told */
    }
    if (errno == 0) {                                /* an earlier write failed: one more tells why */
        fputc('\n', stdout);
        (void)fflush(stdout);
    }
    fail(j, "standard output: %s", errno != 0 ? strerror(errno) : "cannot write");
    return status != 0 ? status : FAILURE;
}

/* Of the standard streams those that are closed get a file that can only fail, so that no output gets their number,
   and with it the report: /dev/null, the input for writing and the others for reading. */
static void fill_streams(void)
{
#ifndef _WIN32
    int file;
    do {
        file = open("/dev/null", O_RDONLY);
        if (file == 0) {
            close(0);
            file = open("/dev/null", O_WRONLY);
        }
    } while (file >= 0 && file <= 2);
    if (file > 2) {
        close(file);
    }
#endif
}

int main(int argc, char **argv)
{
    job j;
    int status, i;
    fill_streams();
    memset(&j, 0, sizeof j);
    j.report = stdout;
    status = parse(argc, argv, &j);
    if (status != 0) {
        free(j.given);
        return end_report(&j, status - 1);
    }
    status = add_points(&j);
    for (i = 0; i < j.outputs; i++) {
        j.report = strcmp(j.output[i], "-") == 0 ? stderr : j.report;
    }
    j.terminal = !j.quiet && isatty(2);
    j.build.progress = on_progress;
    j.build.progress_user = &j;
    status = status != 0 ? status : check_outputs(&j);
    status = status != 0 ? status : check_effects(&j);
    if (status == 0) {
        catch_interrupt();
        start_clock(&j);
        status = j.command->run(&j);
    }
    free(j.given);
    free(j.inside);
    free(j.links);
    free(j.patches);
    free(j.over);
    free(j.build.trace);
    pbw_free(&j.mesh);
    pbwio_free(&j.cloud);
    pbwio_free(&j.surface);
    pbwio_free(&j.queries);
    status = end_report(&j, status);
    if (interrupted) {                               /* by the signal itself, so that a loop of a shell ends, too */
        signal(SIGINT, SIG_DFL);
        raise(SIGINT);
    }
    return status;
}
