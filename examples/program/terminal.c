/* terminal.c: the report, the bar, failures, Ctrl-C. */
#ifndef _WIN32
#define _POSIX_C_SOURCE 200809L                      /* clock_gettime and so on beside strict C99 */
#endif
#include "program.h"
#include <errno.h>
#include <stdarg.h>
#ifdef _WIN32
#include <windows.h>
#else
#include <time.h>
#include <unistd.h>
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
static volatile sig_atomic_t drawing, silent, clocked;  /* seconds without a sign; whether the line shows them */

#ifndef _WIN32
/* Each second: where work gives no sign for two, as in reading a large file, the line shows how long.  Calls nothing
   but what handlers may call. */
static void on_second(int number)
{
    char text[sizeof shown + 24] = "\r", digits[12];
    size_t length = 1, i = sizeof digits;
    const int error = errno;
    if (!drawing && shown[0] != 0 && ++silent >= 2) {
        unsigned rest = (unsigned)silent;
        for (; length < sizeof shown && shown[length - 1] != 0; length++) {
            text[length] = shown[length - 1];
        }
        for (; rest > 0; rest /= 10) {
            digits[--i] = (char)('0' + rest % 10);
        }
        text[length++] = ' ';
        while (i < sizeof digits) {
            text[length++] = digits[i++];
        }
        memcpy(text + length, " s\033[K", 5);
        clocked = write(2, text, length + 5) > 0;
    }
    (void)number;
    alarm(1);
    errno = error;
}
#endif

void start_clock(const job *j)
{
#ifndef _WIN32
    struct sigaction action;
    if (j->terminal) {
        memset(&action, 0, sizeof action);
        action.sa_handler = on_second;
        action.sa_flags = SA_RESTART;
        sigemptyset(&action.sa_mask);
        sigaction(SIGALRM, &action, NULL);
        alarm(1);
    }
#else
    (void)j;
#endif
}

static void show(const job *j, const char *text)
{
    if (j->terminal && (clocked || strcmp(text, shown) != 0)) {
        drawing = 1;
        fprintf(stderr, "\r%s\033[K", text);
        snprintf(shown, sizeof shown, "%s", text);
        drawing = silent = clocked = 0;
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
