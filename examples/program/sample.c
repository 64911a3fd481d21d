/* sample.c: pbw sample. */
#include "program.h"

static const char *const fills[] = { "lattice", "poisson", NULL };

static const option sample_options[] = {
    OPTION_COUNT("points on the surface, default 20000"),
    { "--radius", "R", "instead: that distance apart, as many as there is room for", POSITIVE, 0, 0, NULL },
    { "--uniform", NULL, "independent random points instead, with --count", SWITCH, 0, 0, NULL },
    { "--fill", "WAY", "add points inside, as far apart: lattice (a jittered one) or poisson\n(blue noise)", CHOICE,
      0, 0, fills },
    { "--thin", NULL, "sides of a sheet thinner than the radius do not keep points apart", SWITCH, 0, 0, NULL },
    { "--facet-normals", NULL, "normals of the faces, not interpolated ones", SWITCH, 0, 0, NULL },
    OPTION_SEED,
    { NULL, NULL, NULL, SWITCH, 0, 0, NULL }
};

/* Fills the set: on the surface, then inside. */
static pbw_status make(job *j, const pbwsample_model *model, pbwsample_set *set)
{
    pbwsample_options options;
    pbw_status status;
    double start = now();
    size_t on_surface;
    int uniform = is_given(j, "--uniform");
    memset(&options, 0, sizeof options);
    options.seed = (uint64_t)number_of(j, "--seed", 1);
    options.radius = number_of(j, "--radius", 0);
    options.count = (size_t)number_of(j, "--count", options.radius > 0 ? 0 : 20000);
    options.flags = PBWSAMPLE_NORMALS | (is_given(j, "--thin") ? PBWSAMPLE_THIN : 0)
                  | (is_given(j, "--facet-normals") ? PBWSAMPLE_FACET_NORMALS : 0);
    options.build = &j->build;
    status = uniform ? pbwsample_uniform(model, &options, set) : pbwsample_poisson(model, &options, set);
    if (status != PBW_OK) {
        return status;
    }
    on_surface = set->count;
    if (uniform) {
        report_step(j, "sample", now() - start, "%zu point%s", COUNT(set->count));
    } else {
        report_step(j, "sample", now() - start, "%zu point%s, none closer than %g", COUNT(set->count), set->radius);
    }
    if (is_given(j, "--fill")) {
        start = now();
        options.count = 0;
        options.radius = 0;
        options.flags |= choice_of(j, "--fill") == 0 ? PBWSAMPLE_LATTICE : 0;
        status = pbwsample_volume(model, &options, set);
        if (status == PBW_OK) {
            report_step(j, "fill", now() - start, "%zu point%s inside", COUNT(set->count - on_surface));
        }
    }
    return status;
}

static int run(job *j)
{
    pbwio_cloud normals;
    pbwsample_model model;
    pbwsample_set set;
    pbw_status status;
    pbwmodel_content content;
    int failed;
    j->read.dim = 3;
    failed = load(j, 0);
    if (failed) {
        return failed;
    }
    if (j->cloud.triangle_count == 0) {
        return fail(j, "%s: a model with faces is needed", j->input);
    }
    memset(&normals, 0, sizeof normals);
    memset(&set, 0, sizeof set);
    model = model_of(&j->cloud);
    if (pbwmodel_read_normals(j->input, &j->cloud, &normals)) {
        model.normals = normals.points;
        model.normal_count = normals.count;
        model.normal_ids = normals.triangles;
    }
    if (!describe_surface(j, &j->cloud, 0) && is_given(j, "--fill")) {
        warn(j, "the surface is not closed: what is inside is decided by two of three rays");
    }
    status = make(j, &model, &set);
    if (status != PBW_OK) {
        failed = interrupted ? stopped(j) : fail(j, "%s", pbwsample_status_string(status));
    } else {
        memset(&content, 0, sizeof content);
        content.dim = 3;
        content.points = set.points;
        content.point_count = set.count;
        content.normals = is_given(j, "--fill") ? NULL : set.normals;        /* there are none inside */
        failed = write_model(j, &content);
    }
    pbwio_free(&normals);
    pbwsample_free(&set);
    return failed;
}

const command command_sample = {
    .name = "sample",
    .summary = "spread points over a model",
    .usage =
    "usage: pbw sample [options] model -o output...\n"
    "\n"
    "Points spread evenly over the surface of a model, none closer to another than a radius, with normals.\n"
    "\n"
    "input:   .obj .ply .stl .off .msh .mesh .inp .vtu .vtk with faces\n"
    "output:  .ply .obj .off .xyz .csv; any number of them\n"
    "\n",
    .writes = "ply obj off xyz csv txt pts asc dat tsv",
    .options = { sample_options, output_options, text_options, common_options, NULL },
    .run = run,
};
