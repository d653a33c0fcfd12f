/* Engines that stand still, and whose answer to adapt() or remove() is wrong in the way that is asked for.
 *
 *     answers fluid|particles HOW
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "sillage_engine.h"

#define GRAINS_MAX 64

static const char *how;
static double position[3 * GRAINS_MAX];

static int wanted(const char *name)
{
    return strcmp(how, name) == 0;
}

/* A square of two triangles. */
static int32_t square(sillage_engine *engine, void *user, const sillage_fluid_scene *scene,
                      sillage_mesh *mesh)
{
    static const double nodes[8] = {0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0};
    static const uint32_t triangles[6] = {0, 1, 2, 0, 2, 3};
    (void)engine, (void)user, (void)scene;
    mesh->node_count = 4;
    mesh->node_position = nodes;
    mesh->simplex_count = 2;
    mesh->simplex_nodes = triangles;
    return 0;
}

static int32_t adapt(sillage_engine *engine, void *user, const sillage_sizes *sizes, sillage_mesh *mesh)
{
    static const double odd[12] = {0.0, 0.0, 1.0, NAN, 1.0, 1.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0};
    static const uint32_t far[6] = {0, 1, 2, 0, 2, 9}, turned[6] = {0, 1, 2, 0, 3, 2};
    (void)sizes;
    if (wanted("keeps"))
        return 0;
    if (wanted("silent"))
        return 1;
    if (wanted("fails"))
        return sillage_fail(engine, SILLAGE_FAILURE_NOT_CONVERGED, "no such triangles after 9 tries");
    square(engine, user, NULL, mesh);
    if (wanted("no-nodes"))
        mesh->node_position = NULL;
    if (wanted("no-simplices"))
        mesh->simplex_nodes = NULL;
    if (wanted("many-nodes"))
        mesh->node_count = UINT64_MAX;
    if (wanted("many-simplices"))
        mesh->simplex_count = UINT64_MAX;
    if (wanted("far-node"))
        mesh->simplex_nodes = far;
    if (wanted("turned"))
        mesh->simplex_nodes = turned;
    if (wanted("odd-node"))
        mesh->node_position = odd;
    if (wanted("odd-corner"))
        mesh->simplex_position = odd;
    if (wanted("odd-mass"))
        mesh->nodal_mass = odd;
    if (wanted("odd-period"))
        mesh->period = odd + 2;
    return 0;
}

static int32_t at_rest(sillage_engine *engine, void *user, const sillage_request *request,
                       const sillage_inputs *inputs, const sillage_outputs *outputs,
                       sillage_fluid_report *report)
{
    (void)engine, (void)user, (void)inputs, (void)report;
    const size_t bytes = request->count * sizeof(double);
    memset(sillage_output(outputs, SILLAGE_FIELD_INTERSTITIAL_VELOCITY), 0, 2 * bytes);
    memset(sillage_output(outputs, SILLAGE_FIELD_PRESSURE_GRADIENT), 0, 2 * bytes);
    memset(sillage_output(outputs, SILLAGE_FIELD_PRESSURE), 0, bytes);
    return 0;
}

static int32_t place(sillage_engine *engine, void *user, const sillage_particle_scene *scene,
                     sillage_grains *grains)
{
    (void)user;
    if (grains->count > GRAINS_MAX)
        return sillage_fail(engine, SILLAGE_FAILURE_SCENE, "too many grains");
    memset(grains->velocity, 0, scene->dimension * grains->count * sizeof(double));
    memcpy(position, grains->position, scene->dimension * grains->count * sizeof(double));
    return 0;
}

static int32_t stand(sillage_engine *engine, void *user, const sillage_request *request,
                     const sillage_inputs *inputs, const sillage_outputs *outputs,
                     sillage_particle_report *report)
{
    const size_t bytes = request->count * sizeof(double), d = request->dimension;
    (void)engine, (void)user, (void)inputs;
    memcpy(sillage_output(outputs, SILLAGE_FIELD_GRAIN_POSITION), position, d * bytes);
    memset(sillage_output(outputs, SILLAGE_FIELD_GRAIN_VELOCITY), 0, d * bytes);
    memset(sillage_output(outputs, SILLAGE_FIELD_GRAIN_MEAN_VELOCITY), 0, d * bytes);
    memset(sillage_output(outputs, SILLAGE_FIELD_GRAIN_CONTACT), 0, bytes);
    report->sub_steps = 1;
    return 0;
}

static int32_t leave(sillage_engine *engine, void *user, const uint64_t *gone, uint64_t gone_count,
                     sillage_grains *left)
{
    (void)user, (void)gone, (void)gone_count;
    if (wanted("silent"))
        return 1;
    if (wanted("fails"))
        return sillage_fail(engine, SILLAGE_FAILURE_ENGINE, "they hold on to each other");
    if (wanted("tells-nothing"))
        return 0;
    /* Those of the plane; where they are does not matter here. */
    memset(left->position, 0, 2 * left->count * sizeof(double));
    if (wanted("no-velocity"))
        return 0;
    memset(left->velocity, 0, 2 * left->count * sizeof(double));
    if (wanted("one-more"))
        left->count += 1;
    if (wanted("one-less"))
        left->count -= 1;
    if (wanted("odd-mass"))
        left->mass[2] = INFINITY;
    if (wanted("elsewhere"))
        left->position = NULL;
    return 0;
}

static int32_t commit(sillage_engine *engine, void *user)
{
    (void)engine, (void)user;
    return 0;
}

int main(int argc, char **argv)
{
    const sillage_fluid_calls fluid = {
        .configure = square, .advance = at_rest, .commit = commit, .adapt = adapt};
    const sillage_particle_calls particles = {
        .configure = place, .advance = stand, .commit = commit, .remove = leave};
    sillage_engine *engine = sillage_engine_new("answers", "1");
    if (argc != 3 || !engine)
        return 2;
    how = argv[2];
    int code;
    if (strcmp(argv[1], "fluid") == 0) {
        sillage_engine_declare(engine, SILLAGE_ADAPTS);
        code = sillage_run_fluid(engine, &fluid, NULL);
    } else {
        sillage_engine_declare(engine, SILLAGE_REMOVES_GRAINS);
        code = sillage_run_particles(engine, &particles, NULL);
    }
    sillage_engine_free(engine);
    return code;
}
