# embed.awk: prints a header with the page of a folder in it:
#     awk -v name=pbwview -f embed.awk FOLDER/page.html pbw_view.h
# Style sheets and scripts that page.html names are put into it, all scripts as one function; <!-- title --> and
# <!-- data --> end the first and the second part; <!-- room TAG Title.  In: ...  Out: ... --> becomes a banner of the
# header.  Files are ASCII: mawk and gawk then print the same bytes.
function emit(text)
{
    gsub(/\\/, "&&", text)
    gsub(/"/, "\\\"", text)
    line[++lines] = "    \"" text "\\n\","
}
function inline(file,   text, status)
{
    while ((status = (getline text < (folder file))) > 0) {
        emit(text)
    }
    if (status < 0) {
        print "embed.awk: no " folder file > "/dev/stderr"
        failed = 1
        exit
    }
    close(folder file)
}
function part()
{
    line[++lines] = "    NULL"
    line[++lines] = "};"
    line[++lines] = "static const char *const " name "__part" ++parts "[] = {"
}
function room(text,   rule, tag, title)
{
    rule = sprintf("%102s", "")
    gsub(/ /, "-", rule)
    gsub(/^<!-- room | -->$/, "", text)
    tag = title = text
    sub(/ .*/, "", tag)
    sub(/^[^ ]* /, "", title)
    sub(/  In: .*/, "", title)
    sub(/.*  In: /, "In: ", text)
    line[++lines] = "/* " rule
    line[++lines] = sprintf("   >>%-12s %s", tag, title)
    line[++lines] = "   " text
    line[++lines] = "   " rule " */"
}
function named(text)
{
    sub(/.*(src|href)='/, "", text)
    sub(/'.*/, "", text)
    return text
}
FNR == 1 && NR == 1 {
    folder = FILENAME
    sub(/[^\/]*$/, "", folder)
    line[++lines] = "static const char *const " name "__part0[] = {"
}
NR != FNR && !ends { line[++lines] = "    NULL"; line[++lines] = "};"; ends = 1 }
NR == FNR && /^<!-- (title|data) -->$/ { part(); next }
NR == FNR && /^<!-- room / { room($0); next }
NR == FNR && /^<link rel='stylesheet'/ { emit("<style>"); inline(named($0)); emit("</style>"); next }
NR == FNR && /^<script src=/ {
    if (!scripts++) {
        emit("<script>"); emit("(() => {"); emit("'use strict';")
    }
    inline(named($0))
    next
}
NR == FNR {
    if (scripts && !closed++) {
        emit("})();"); emit("</script>")
    }
    emit($0)
    next
}
skipping && /^#endif/ { skipping = 0 }
!skipping { print }
/The page, made of the files in/ { made = 1 }
made && /^ +-+ \*\/$/ {
    made = 0
    skipping = 1
    for (i = 1; i <= lines; i++) {
        print line[i]
    }
    print ""
    print "static const char *const *" name "__part(int part)"
    print "{"
    print "    return part == 0 ? " name "__part0 : part == 1 ? " name "__part1 : " name "__part2;"
    print "}"
}
END { exit failed }
