/* terminal.c: the report, the bar, failures, Ctrl-C. */
#ifndef _WIN32
#define _POSIX_C_SOURCE 199309L                      /* clock_gettime beside strict C99 */
#endif
#include "program.h"
#include <stdarg.h>
#ifdef _WIN32
#include <windows.h>
#else
#include <time.h>
#endif

volatile sig_atomic_t interrupted;

static void on_interrupt(int number)                 /* the first stops the work, a second one the program */
{
    interrupted = 1;
    signal(number, SIG_DFL);
}

void catch_interrupt(void)
{
    if (signal(SIGINT, on_interrupt) == SIG_IGN) {   /* as in the background of a shell: leave it so */
        signal(SIGINT, SIG_IGN);
    }
}

double now(void)                                     /* of a clock that nobody sets */
{
#ifdef _WIN32
    LARGE_INTEGER count, frequency;
    QueryPerformanceCounter(&count);
    QueryPerformanceFrequency(&frequency);
    return (double)count.QuadPart / (double)frequency.QuadPart;
#else
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
#endif
}

static char shown[128];                              /* what the terminal's last line has of us, "" for nothing */

static void show(const job *j, const char *text)
{
    if (j->terminal && strcmp(text, shown) != 0) {
        fprintf(stderr, "\r%s\033[K", text);
        snprintf(shown, sizeof shown, "%s", text);
    }
}

int draw_bar(const job *j, const char *name, double done)
{
    const int length = (int)(40 * done);
    char text[128];
    snprintf(text, sizeof text, "%-9s [%.*s%*s] %3.0f %%", name, length, "########################################",
             40 - length, "", floor(100 * done));
    show(j, text);
    return interrupted;
}

void begin(const job *j, const char *name, const char *what)
{
    char text[128];
    snprintf(text, sizeof text, "%-9s %.60s ...", name, what);
    show(j, text);
}

static void clear_bar(const job *j)
{
    fflush(j->report);
    show(j, "");
}

int fail(const job *j, const char *format, ...)
{
    va_list list;
    clear_bar(j);
    fputs("pbw: ", stderr);
    va_start(list, format);
    vfprintf(stderr, format, list);
    va_end(list);
    fputc('\n', stderr);
    return FAILURE;
}

int stopped(const job *j)
{
    int i;
    clear_bar(j);
    fputs("pbw: interrupted", stderr);
    for (i = 0; i < j->outputs; i++) {
        fprintf(stderr, "%s%s", i == 0 && i < j->written ? "; written: " : i == j->written ? "; not written: " : ", ",
                j->output[i]);
    }
    fputc('\n', stderr);
    return FAILURE;
}

void warn(const job *j, const char *format, ...)
{
    va_list list;
    clear_bar(j);
    if (!j->quiet) {
        fputs("pbw: warning: ", stderr);
        va_start(list, format);
        vfprintf(stderr, format, list);
        va_end(list);
        fputc('\n', stderr);
    }
}

void report_step(const job *j, const char *what, double seconds, const char *format, ...)
{
    va_list list;
    char text[1200];                                 /* the names of outputs have at most 1000 */
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    clear_bar(j);
    if (!j->quiet) {
        fprintf(j->report, "%-9s %8.3f s%s%s\n", what, seconds, *text != 0 ? "   " : "", text);
        fflush(j->report);
    }
}

void report_line(const job *j, const char *format, ...)
{
    va_list list;
    clear_bar(j);
    if (!j->quiet) {
        va_start(list, format);
        vfprintf(j->report, format, list);
        va_end(list);
        fputc('\n', j->report);
    }
}

const char *plural(size_t count)
{
    return count == 1 ? "" : "s";
}
