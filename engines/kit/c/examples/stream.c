/* A fluid engine in C: a uniform stream that nothing disturbs, on a rectangle of triangles.
 *
 *     stream VX VY        interstitial velocity (m/s)
 */
#include <stdio.h>
#include <stdlib.h>

#include "sillage_engine.h"

typedef struct {
    double velocity[2];
    double weight[2]; /* density times gravity (N/m3) */
    double *node_position;
    uint32_t *triangles;
} model;

static int32_t configure(sillage_engine *engine, void *user, const sillage_fluid_scene *scene,
                         sillage_mesh *mesh)
{
    model *m = user;
    if (scene->dimension != 2)
        return sillage_fail(engine, SILLAGE_FAILURE_SCENE, "stream is for two dimensions");
    if (scene->mesh_file)
        return sillage_fail(engine, SILLAGE_FAILURE_SCENE, "stream takes rectangles, no mesh files");
    const uint64_t nx = scene->cells[0], ny = scene->cells[1];
    for (uint32_t b = 0; b < scene->boundary_count; ++b)
        if (scene->boundaries[b].condition == SILLAGE_PERIODIC)
            return sillage_fail(engine, SILLAGE_FAILURE_SCENE, "stream has no periodic sides");
    m->node_position = malloc(2 * (nx + 1) * (ny + 1) * sizeof(double));
    m->triangles = malloc(6 * nx * ny * sizeof(uint32_t));
    if (!m->node_position || !m->triangles)
        return sillage_fail(engine, SILLAGE_FAILURE_ENGINE, "no memory for the mesh");
    for (uint64_t j = 0; j <= ny; ++j)
        for (uint64_t i = 0; i <= nx; ++i) {
            double *x = &m->node_position[2 * (j * (nx + 1) + i)];
            x[0] = scene->lower[0] + (double)i / (double)nx * (scene->upper[0] - scene->lower[0]);
            x[1] = scene->lower[1] + (double)j / (double)ny * (scene->upper[1] - scene->lower[1]);
        }
    for (uint64_t j = 0; j < ny; ++j)
        for (uint64_t i = 0; i < nx; ++i) {
            const uint32_t a = (uint32_t)(j * (nx + 1) + i), d = a + (uint32_t)nx + 1;
            const uint32_t corners[6] = {a, a + 1, d + 1, a, d + 1, d};
            for (unsigned k = 0; k < 6; ++k)
                m->triangles[6 * (j * nx + i) + k] = corners[k];
        }
    for (unsigned axis = 0; axis < 2; ++axis)
        m->weight[axis] = scene->density * scene->gravity[axis];
    /* Corner coordinates and nodal masses are left to the library. */
    mesh->node_count = (nx + 1) * (ny + 1);
    mesh->node_position = m->node_position;
    mesh->simplex_count = 2 * nx * ny;
    mesh->simplex_nodes = m->triangles;
    return 0;
}

static int32_t advance(sillage_engine *engine, void *user, const sillage_request *request,
                       const sillage_inputs *inputs, const sillage_outputs *outputs,
                       sillage_fluid_report *report)
{
    const model *m = user;
    double *velocity = sillage_output(outputs, SILLAGE_FIELD_INTERSTITIAL_VELOCITY);
    double *gradient = sillage_output(outputs, SILLAGE_FIELD_PRESSURE_GRADIENT);
    double *pressure = sillage_output(outputs, SILLAGE_FIELD_PRESSURE);
    (void)engine, (void)inputs, (void)report;
    for (uint64_t node = 0; node < request->count; ++node) {
        const double *x = &m->node_position[2 * node];
        for (unsigned axis = 0; axis < 2; ++axis) {
            velocity[2 * node + axis] = m->velocity[axis];
            gradient[2 * node + axis] = m->weight[axis];
        }
        pressure[node] = m->weight[0] * x[0] + m->weight[1] * x[1];
    }
    return 0;
}

static int32_t commit(sillage_engine *engine, void *user)
{
    (void)engine, (void)user;
    return 0;
}

int main(int argc, char **argv)
{
    const sillage_fluid_calls calls = {configure, advance, commit, NULL, NULL};
    model m = {0};
    int code = -1;
    if (argc == 3)
        for (unsigned axis = 0; axis < 2; ++axis)
            m.velocity[axis] = strtod(argv[1 + axis], NULL);
    sillage_engine *engine = sillage_engine_new("stream-c", "1.0");
    if (engine)
        code = sillage_run_fluid(engine, &calls, &m);
    if (code < 0) {
        fprintf(stderr, "stream: %s\n", sillage_last_error());
        code = 4;
    }
    sillage_engine_free(engine);
    free(m.node_position);
    free(m.triangles);
    return code;
}
