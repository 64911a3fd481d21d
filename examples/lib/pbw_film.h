/* pbw_film.h - v0.2.0 - pages that play a changing plane mesh in a browser - MIT-0

   QUICK START
   In one source file, define PBW_FILM_IMPLEMENTATION before the include; in all others, only include.
   Needs pbw_io.h, with its implementation in some source file.

       pbwfilm_options options = {0};
       pbwio_error error;
       options.box[2] = options.box[3] = 1;                          // the unit square is seen
       if (pbwfilm_write("film.html", &options, next, user, &error) != PBWIO_OK) puts(error.text);

   FUNCTIONS
     pbwfilm_write  writes a page that plays steps of points

   CONTENTS  (search for the marks)
     >>interface    types and functions
     >>shapes       shapes of a frame as bytes
     >>emit         the file, frame after frame
     >>page         the page

   HOW
     1. `next` is your function.  It simulates a step, sets members of the frame and returns 1; 0 after the last
        frame; -1 if it failed.
     2. A frame is a set of dots, lines and polygons, coloured by a number: triangles of a mesh, cells of a diagram, a
        front.
     3. The page is one file and needs no network and no server; it has play, step and speed.

   PROMISES  (tests/view.sh and tests/page.sh guard them)
     small       2.7 bytes a shape and 5.4 a corner in each frame; browsers draw 10,000 polygons 30 times a second
     whole       there is the whole page or none
     bounded     memory for a name alone, through options.build->resize
     quiet       no globals, nothing printed, no exit
*/
#ifndef PBW_FILM_H
#define PBW_FILM_H
/* ------------------------------------------------------------------------------------------------------
   >>interface    types and functions
   ------------------------------------------------------------------------------------------------------ */
#ifndef PBW_IO_H
#include "pbw_io.h"
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pbwfilm_frame {         /* all zero before each call of next */
    size_t count;                      /* shapes */
    const size_t *first;               /* count + 1: corners of shape i are first[i] .. first[i+1]-1, 255 at most;
                                          NULL = each has `corners` */
    size_t corners;                    /* 1: dots, 2: lines, 3: triangles, ... */
    const pbw_index *corner;           /* numbers of points; NULL = 0, 1, 2, ... */
    const double *points;              /* 2 each */
    const double *values;              /* one a shape, NaN = no colour; NULL = none */
    size_t line_count;                 /* lines on top of the shapes */
    const pbw_index *lines;            /* 2 numbers of points each */
    const char *label;                 /* UTF-8; NULL = none */
} pbwfilm_frame;

typedef struct pbwfilm_options {
    const char *title, *note;          /* UTF-8, any characters; NULL = "pbw", none */
    const char *value_name;            /* what colours show; NULL = no legend */
    double box[4];                     /* what is seen: least x, y, largest x, y */
    double range[2];                   /* values that get the first and the last colour */
    size_t frames;                     /* that there will be, for progress; 0 = not known */
    const pbw_options *build;          /* memory_limit, resize, progress before each frame, as in pbw.h; NULL =
                                          defaults */
} pbwfilm_options;

/* Calls next, which fills a frame and returns 1, until it returns 0.  The caller owns the arrays of a frame; they are
   read before next is called again.  Writes the page whole or not at all.  PBWIO_ERROR_ARGUMENT: an empty box;
   PBWIO_CANCELLED: next returned -1, or progress said stop. */
PBWDEF pbwio_status pbwfilm_write(const char *path, const pbwfilm_options *options,
                                  int (*next)(void *user, pbwfilm_frame *frame), void *user, pbwio_error *error);

#ifdef __cplusplus
}
#endif
#endif /* PBW_FILM_H */

#if defined(PBW_FILM_IMPLEMENTATION) && !defined(PBWFILM__IMPLEMENTED)
#define PBWFILM__IMPLEMENTED

#include <string.h>

/* Returns the lines of one of three parts of the page: up to the title, up to the data, after the data.  NULL ends
   the lines.  They are at the end of this file. */
static const char *const *pbwfilm__part(int part);

/* ------------------------------------------------------------------------------------------------------
   >>shapes       The shapes of a frame as bytes.
   In: a frame, the box that is seen.  Out: base64: the corners and the colour of each shape, then its points.
   Holds: coordinates are 16 bits, 8192 to 57344 across the box.
   ------------------------------------------------------------------------------------------------------ */

typedef struct pbwfilm__page {
    const pbwfilm_options *options;
    int (*next)(void *user, pbwfilm_frame *frame);
    void *user;
    FILE *file;
    int cancelled;
    unsigned char in[3];               /* bytes on their way to base64 */
    int in_count, column;
} pbwfilm__page;

static void pbwfilm__group(pbwfilm__page *page)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const unsigned bits = (unsigned)page->in[0] << 16 | (unsigned)page->in[1] << 8 | page->in[2];
    int i;
    for (i = 0; i < 4; i++) {
        putc(i <= page->in_count ? digits[bits >> (18 - 6 * i) & 63] : '=', page->file);
    }
    memset(page->in, 0, sizeof page->in);
    page->in_count = 0;
    page->column += 4;
    if (page->column >= 4096) {
        putc('\n', page->file);
        page->column = 0;
    }
}

static void pbwfilm__byte(pbwfilm__page *page, unsigned byte)
{
    page->in[page->in_count++] = (unsigned char)byte;
    if (page->in_count == 3) {
        pbwfilm__group(page);
    }
}

/* Text for between tags and for between quotes. */
static void pbwfilm__text(FILE *file, const char *text)
{
    for (; text != NULL && *text != 0; text++) {
        if (strchr("&<>\"'", *text) != NULL) {
            fprintf(file, "&#%d;", *text);
        } else {
            putc(*text, file);
        }
    }
}

/* A coordinate in 16 bits: 8192 to 57344 across the box; less and more beside it. */
static void pbwfilm__coordinate(pbwfilm__page *page, double x, int axis)
{
    const double *box = page->options->box;
    const double scaled = 8192 + 49152 * ((x - box[axis]) / (box[2 + axis] - box[axis]));
    const unsigned whole = scaled >= 65535 ? 65535 : scaled > 0 ? (unsigned)(scaled + 0.5) : 0;
    pbwfilm__byte(page, whole & 255);
    pbwfilm__byte(page, whole >> 8);
}

static void pbwfilm__corner(pbwfilm__page *page, const double *point)
{
    pbwfilm__coordinate(page, point[0], 0);
    pbwfilm__coordinate(page, point[1], 1);
}

/* The colour of a value: 1 to 255, and 0 for NaN. */
static unsigned pbwfilm__colour(const pbwfilm_options *o, double value)
{
    const double scaled = 1 + 254 * ((value - o->range[0]) / (o->range[1] - o->range[0]));
    return scaled >= 255 ? 255 : scaled > 1 ? (unsigned)scaled : scaled <= 1 ? 1 : 0;
}

static void pbwfilm__shapes(pbwfilm__page *page, const pbwfilm_frame *frame)
{
    size_t i, j;
    for (i = 0; i < frame->count; i++) {
        const size_t from = frame->first != NULL ? frame->first[i] : i * frame->corners;
        const size_t to = frame->first != NULL ? frame->first[i + 1] : from + frame->corners;
        if (to == from || to - from > 255) {
            continue;
        }
        pbwfilm__byte(page, (unsigned)(to - from));
        pbwfilm__byte(page, frame->values != NULL ? pbwfilm__colour(page->options, frame->values[i]) : 0);
        for (j = from; j < to; j++) {
            pbwfilm__corner(page, frame->points + 2 * (frame->corner != NULL ? frame->corner[j] : j));
        }
    }
    for (i = 0; i < frame->line_count; i++) {
        pbwfilm__byte(page, 2);
        pbwfilm__byte(page, 0);
        pbwfilm__corner(page, frame->points + 2 * (size_t)frame->lines[2 * i]);
        pbwfilm__corner(page, frame->points + 2 * (size_t)frame->lines[2 * i + 1]);
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>emit         The file, frame after frame.
   In: the options, frames from the caller.  Out: the page, or a status and a message.
   Holds: one frame at a time.
   ------------------------------------------------------------------------------------------------------ */

static void pbwfilm__lines(FILE *file, const char *const *line)
{
    for (; *line != NULL; line++) {
        fputs(*line, file);
    }
}

/* Fills the next frame.  Returns 0 if there is none, or if the film is cancelled. */
static int pbwfilm__next(pbwfilm__page *page, size_t number, pbwfilm_frame *frame)
{
    const pbw_options *build = page->options->build;
    const size_t frames = page->options->frames > number ? page->options->frames : number + 1;
    int more;
    if (build != NULL && build->progress != NULL
        && build->progress(build->progress_user, PBW_STAGE_WORK, (double)number / (double)frames) != 0) {
        page->cancelled = 1;
        return 0;
    }
    memset(frame, 0, sizeof *frame);
    more = page->next(page->user, frame);
    page->cancelled = more < 0;
    return more > 0;
}

static int pbwfilm__is_cancelled(void *user, pbw_stage stage, double done)
{
    (void)stage;
    (void)done;
    return ((const pbwfilm__page *)user)->cancelled;
}

static void pbwfilm__emit(void *user, FILE *file)
{
    pbwfilm__page *page = (pbwfilm__page *)user;
    const pbwfilm_options *o = page->options;
    pbwfilm_frame frame;
    size_t i;
    page->file = file;
    pbwfilm__lines(file, pbwfilm__part(0));
    fputs("<title>", file);
    pbwfilm__text(file, o->title != NULL ? o->title : "pbw");
    fputs("</title>\n", file);
    pbwfilm__lines(file, pbwfilm__part(1));
    fprintf(file, "<script type='text/plain' id='film' data-box='%.17g %.17g %.17g %.17g' data-least='%.6g'"
            " data-most='%.6g' data-name='", o->box[0], o->box[1], o->box[2], o->box[3], o->range[0], o->range[1]);
    pbwfilm__text(file, o->value_name);
    fputs("' data-note='", file);
    pbwfilm__text(file, o->note);
    fputs("'></script>\n", file);
    for (i = 0; pbwfilm__next(page, i, &frame); i++) {
        fputs("<script type='text/plain' data-label='", file);
        pbwfilm__text(file, frame.label);
        fputs("'>\n", file);
        page->column = 0;
        pbwfilm__shapes(page, &frame);
        if (page->in_count > 0) {
            pbwfilm__group(page);
        }
        fputs("</script>\n", file);
    }
    pbwfilm__lines(file, pbwfilm__part(2));
}

PBWDEF pbwio_status pbwfilm_write(const char *path, const pbwfilm_options *options,
                                  int (*next)(void *user, pbwfilm_frame *frame), void *user, pbwio_error *error)
{
    pbwfilm__page page;
    pbw_options build;
    memset(&page, 0, sizeof page);
    memset(&build, 0, sizeof build);
    if (options == NULL || next == NULL || !(options->box[0] < options->box[2])
        || !(options->box[1] < options->box[3])) {
        if (error != NULL) {
            strcpy(error->text, "pbwfilm_write: an argument is NULL, or the box is empty");
        }
        return PBWIO_ERROR_ARGUMENT;
    }
    page.options = options;
    page.next = next;
    page.user = user;
    build = options->build != NULL ? *options->build : build;
    build.progress = pbwfilm__is_cancelled;
    build.progress_user = &page;
    return pbwio_save(path, pbwfilm__emit, &page, &build, error);
}

/* ------------------------------------------------------------------------------------------------------
   >>page         The page, made of the files in examples/lib/film/ by `make page`: edit those.
   In: nothing.  Out: pbwfilm__part: lines of HTML, styles and scripts.
   ------------------------------------------------------------------------------------------------------ */
static const char *const pbwfilm__part0[] = {
    "<!DOCTYPE html>\n",
    "<html lang='en'>\n",
    "<meta charset='utf-8'>\n",
    NULL
};
static const char *const pbwfilm__part1[] = {
    "<meta name='viewport' content='width=device-width, initial-scale=1'>\n",
    "<meta http-equiv='Content-Security-Policy' content='default-src &#39;none&#39;; img-src data:;\n",
    " script-src &#39;unsafe-inline&#39;; style-src &#39;unsafe-inline&#39;'>\n",
    "<link rel='icon' href='data:,'>\n",
    "<style>\n",
    ":root { --back: #fff; --ink: #1d2430; --soft: #5c6675; --line: #fff8; color-scheme: light dark; }\n",
    "@media (prefers-color-scheme: dark) { :root { --back: #12161d; --ink: #e8ecf2; --soft: #9aa5b5; --line: #0008; } }\n",
    "body { margin: 0 auto; padding: 12px 16px; max-width: 1200px; background: var(--back); color: var(--ink);\n",
    "  font: 15px/1.4 system-ui, sans-serif; }\n",
    "h1 { font-size: 20px; margin: 0; }\n",
    "p { margin: 4px 0; color: var(--soft); }\n",
    "#canvas { display: block; width: 100%; border: 1px solid var(--soft); box-sizing: border-box; }\n",
    "#label { min-height: 1.4em; font-variant-numeric: tabular-nums; }\n",
    "#controls, #legend { display: flex; flex-wrap: wrap; gap: 8px; align-items: center; margin: 6px 0; }\n",
    "#frame { flex: 1; min-width: 160px; }\n",
    "#number { min-width: 5.5em; text-align: right; font-variant-numeric: tabular-nums; }\n",
    "#play { min-width: 4.5em; }\n",
    "#scale { width: 256px; height: 14px; border: 1px solid var(--soft); }\n",
    "</style>\n",
    "<h1 id='title'></h1>\n",
    "<p id='note'></p>\n",
    "<canvas id='canvas' role='img' aria-describedby='label'></canvas>\n",
    "<p id='label' role='status'></p>\n",
    "<div id='controls'>\n",
    "<button id='play' title='space'>Play</button>\n",
    "<button id='back' title='arrow left' aria-label='one frame back'>&#9664;</button>\n",
    "<button id='on' title='arrow right' aria-label='one frame on'>&#9654;</button>\n",
    "<input id='frame' type='range' min='0' value='0' step='1' aria-label='frame'>\n",
    "<output id='number'></output>\n",
    "<label>speed <select id='speed'><option value='2'>2<option value='5'>5<option value='10'>10<option value='25'\n",
    " selected>25<option value='60'>60</select> frames/s</label>\n",
    "<label><input id='edges' type='checkbox' checked> edges</label>\n",
    "</div>\n",
    "<div id='legend'><span id='least'></span><canvas id='scale' width='256' height='1'></canvas><span id='most'></span>\n",
    "<span id='name'></span></div>\n",
    NULL
};
static const char *const pbwfilm__part2[] = {
    "<script>\n",
    "(() => {\n",
    "'use strict';\n",
    "// The player.  A frame is a script of base64: of each shape a byte with its number of corners, a byte with its\n",
    "// colour (0: none), and two 16-bit numbers for each corner, 8192 to 57344 across the box.  Shapes of one corner are\n",
    "// dots, of two are lines, of more are polygons.  film.html#80 begins with frame 80.\n",
    "\n",
    "const $ = id => document.getElementById(id), given = $('film').dataset;\n",
    "const frames = [...document.querySelectorAll('script[data-label]')];\n",
    "const box = given.box.split(' ').map(Number), canvas = $('canvas'), context = canvas.getContext('2d');\n",
    "let at = Math.max(0, Math.min(location.hash.slice(1) - 1 || 0, frames.length - 1)), playing = false, last = 0;\n",
    "$('title').textContent = document.title;\n",
    "$('note').textContent = given.note;\n",
    "$('frame').max = frames.length - 1;\n",
    "window.onerror = text => { $('label').textContent = 'This page failed: ' + text; };\n",
    "\n",
    "const stops = [[49, 54, 149], [69, 117, 180], [171, 217, 233], [255, 255, 191], [253, 174, 97], [215, 48, 39],\n",
    "  [165, 0, 38]];\n",
    "const colours = Array.from({ length: 256 }, (_, i) => {\n",
    "  const x = Math.max(i - 1, 0) / 254 * (stops.length - 1), k = Math.min(Math.floor(x), stops.length - 2);\n",
    "  return 'rgb(' + stops[k].map((c, j) => Math.round(c + (x - k) * (stops[k + 1][j] - c))) + ')';\n",
    "});\n",
    "\n",
    "function legend() {\n",
    "  const scale = $('scale').getContext('2d');\n",
    "  for (let i = 0; i < 256; i++) {\n",
    "    scale.fillStyle = colours[Math.max(i, 1)];\n",
    "    scale.fillRect(i, 0, 1, 1);\n",
    "  }\n",
    "  $('least').textContent = given.least;\n",
    "  $('most').textContent = given.most;\n",
    "  $('name').textContent = given.name;\n",
    "  $('legend').hidden = !given.name;\n",
    "}\n",
    "\n",
    "// The shapes of a frame as one path for each colour.\n",
    "function paths_of(frame) {\n",
    "  const text = atob(frame.textContent.replace(/\\s/g, '')), fill = new Map(), line = new Map(), dot = new Map();\n",
    "  const width = canvas.width, height = canvas.height, size = Math.max(1.5, width / 600);\n",
    "  const number = i => text.charCodeAt(i) | text.charCodeAt(i + 1) << 8;\n",
    "  for (let i = 0; i < text.length;) {\n",
    "    const corners = text.charCodeAt(i), colour = text.charCodeAt(i + 1);\n",
    "    const group = corners === 1 ? dot : corners === 2 ? line : fill;\n",
    "    if (!group.has(colour)) group.set(colour, new Path2D());\n",
    "    const path = group.get(colour);\n",
    "    i += 2;\n",
    "    for (let k = 0; k < corners; k++, i += 4) {\n",
    "      const x = (number(i) - 8192) / 49152 * width, y = height - (number(i + 2) - 8192) / 49152 * height;\n",
    "      if (corners === 1) path.rect(x - size / 2, y - size / 2, size, size);\n",
    "      else if (k === 0) path.moveTo(x, y);\n",
    "      else path.lineTo(x, y);\n",
    "    }\n",
    "    if (corners > 2) path.closePath();\n",
    "  }\n",
    "  return { fill, line, dot };\n",
    "}\n",
    "\n",
    "function paint() {\n",
    "  const style = getComputedStyle(document.documentElement), ink = style.getPropertyValue('--ink');\n",
    "  canvas.style.width = '';                       // all of the page's\n",
    "  const wide = canvas.clientWidth, ratio = window.devicePixelRatio || 1, room = window.innerHeight - 190;\n",
    "  const scale = Math.min(wide / (box[2] - box[0]), Math.max(room, 240) / (box[3] - box[1]));\n",
    "  canvas.width = Math.round((box[2] - box[0]) * scale * ratio);\n",
    "  canvas.height = Math.round((box[3] - box[1]) * scale * ratio);\n",
    "  canvas.style.height = canvas.height / ratio + 2 + 'px';                 // and a border\n",
    "  canvas.style.width = canvas.width / ratio + 2 + 'px';\n",
    "  $('number').value = frames.length ? at + 1 + ' of ' + frames.length : 'no frames';\n",
    "  if (!frames.length) return;\n",
    "  $('frame').value = at;\n",
    "  $('label').textContent = frames[at].dataset.label;\n",
    "  const { fill, line, dot } = paths_of(frames[at]);\n",
    "  context.lineWidth = ratio * 0.75;\n",
    "  for (const [colour, path] of fill) {\n",
    "    context.fillStyle = colour ? colours[colour] : '#8884';\n",
    "    context.fill(path);\n",
    "    if (!$('edges').checked && colour) {         // closes the seams between neighbours\n",
    "      context.strokeStyle = colours[colour];\n",
    "      context.stroke(path);\n",
    "    }\n",
    "  }\n",
    "  if ($('edges').checked) {\n",
    "    context.strokeStyle = style.getPropertyValue('--line');\n",
    "    for (const path of fill.values()) context.stroke(path);\n",
    "  }\n",
    "  for (const [colour, path] of dot) {\n",
    "    context.fillStyle = colour ? colours[colour] : ink;\n",
    "    context.fill(path);\n",
    "  }\n",
    "  context.lineWidth = 2 * ratio;\n",
    "  for (const [colour, path] of line) {\n",
    "    context.strokeStyle = colour ? colours[colour] : ink;\n",
    "    context.stroke(path);\n",
    "  }\n",
    "}\n",
    "\n",
    "function go(frame) {\n",
    "  at = Math.min(Math.max(frame, 0), frames.length - 1);\n",
    "  paint();\n",
    "}\n",
    "\n",
    "function tick(now) {\n",
    "  if (!playing) return;\n",
    "  if (now - last >= 1000 / $('speed').value) {\n",
    "    last = now;\n",
    "    go(at + 1 < frames.length ? at + 1 : 0);\n",
    "  }\n",
    "  requestAnimationFrame(tick);\n",
    "}\n",
    "\n",
    "function play(on) {\n",
    "  playing = on && frames.length > 1;\n",
    "  $('play').textContent = playing ? 'Pause' : 'Play';\n",
    "  if (playing) requestAnimationFrame(tick);\n",
    "}\n",
    "\n",
    "function step(by) {\n",
    "  play(false);\n",
    "  go(at + by);\n",
    "}\n",
    "\n",
    "$('play').onclick = () => play(!playing);\n",
    "$('back').onclick = () => step(-1);\n",
    "$('on').onclick = () => step(1);\n",
    "$('frame').oninput = () => { play(false); go(+$('frame').value); };\n",
    "$('edges').onchange = paint;\n",
    "window.onresize = paint;\n",
    "window.onkeydown = event => {\n",
    "  if (event.target.tagName === 'SELECT') return;\n",
    "  if (event.key === ' ' && event.target.tagName !== 'BUTTON') { event.preventDefault(); play(!playing); }\n",
    "  if (event.target.id === 'frame') return;\n",
    "  if (event.key === 'ArrowLeft') step(-1);\n",
    "  if (event.key === 'ArrowRight') step(1);\n",
    "};\n",
    "legend();\n",
    "paint();\n",
    "})();\n",
    "</script>\n",
    "</html>\n",
    NULL
};

static const char *const *pbwfilm__part(int part)
{
    return part == 0 ? pbwfilm__part0 : part == 1 ? pbwfilm__part1 : pbwfilm__part2;
}
#endif /* PBW_FILM_IMPLEMENTATION */
