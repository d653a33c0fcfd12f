/* A fluid engine in C: a uniform stream that nothing disturbs, on a rectangle of triangles whose lines lie
 * as close as the scene, or the coupler between two steps, asks for.
 *
 *     stream VX VY        interstitial velocity (m/s)
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "sillage_engine.h"

/* Larger meshes are refused. */
#define NODES_MAX 4000000.0

typedef struct {
    double velocity[2];
    double weight[2]; /* density times gravity (N/m3) */
    /* The rectangle (m), and its cells where nothing smaller is asked for. */
    double lower[2], upper[2];
    uint64_t cells[2];
    double *node_position;
    uint32_t *triangles;
} model;

/* Smallest cells that are asked for between two lines across an axis (m). */
static double asked(const sillage_sizes *sizes, unsigned axis, double from, double to)
{
    double least = sizes->largest;
    for (uint32_t k = 0; k < sizes->region_count; ++k) {
        const sillage_region *region = &sizes->regions[k];
        const double before = region->lower[axis] - region->radius - to;
        const double beyond = from - (region->upper[axis] + region->radius);
        const double distance = fmax(0.0, fmax(before, beyond));
        least = fmin(least, region->size + sizes->growth * distance);
    }
    return least;
}

/* Where a line of the rectangle as the scene has it lies (m). */
static double line(const model *m, unsigned axis, uint64_t k)
{
    const double share = (double)k / (double)m->cells[axis];
    return m->lower[axis] + share * (m->upper[axis] - m->lower[axis]);
}

/* In how many parts a cell is cut along an axis, so that none is larger than asked for. NULL: one. */
static double parts(const model *m, const sillage_sizes *sizes, unsigned axis, uint64_t cell)
{
    const double from = line(m, axis, cell), to = line(m, axis, cell + 1), round_off = 1e-9;
    return sizes ? fmax(1.0, ceil((to - from) / asked(sizes, axis, from, to) - round_off)) : 1.0;
}

/* Lines across an axis (m), to be freed; NULL without memory. `count` is how many there are. */
static double *lines(const model *m, const sillage_sizes *sizes, unsigned axis, uint64_t count)
{
    double *all = malloc(count * sizeof *all);
    uint64_t k = 0;
    if (!all)
        return NULL;
    for (uint64_t cell = 0; cell < m->cells[axis]; ++cell) {
        const double from = line(m, axis, cell), to = line(m, axis, cell + 1);
        const double cut = parts(m, sizes, axis, cell);
        for (double part = 0.0; part < cut; part += 1.0)
            all[k++] = from + part / cut * (to - from);
    }
    all[k] = m->upper[axis];
    return all;
}

/* Nodes row by row, and two triangles a cell. */
static void fill_in(model *m, const double *x, const double *y, uint64_t nx, uint64_t ny)
{
    for (uint64_t j = 0; j <= ny; ++j)
        for (uint64_t i = 0; i <= nx; ++i) {
            m->node_position[2 * (j * (nx + 1) + i)] = x[i];
            m->node_position[2 * (j * (nx + 1) + i) + 1] = y[j];
        }
    for (uint64_t j = 0; j < ny; ++j)
        for (uint64_t i = 0; i < nx; ++i) {
            const uint32_t a = (uint32_t)(j * (nx + 1) + i), d = a + (uint32_t)nx + 1;
            const uint32_t corners[6] = {a, a + 1, d + 1, a, d + 1, d};
            for (unsigned k = 0; k < 6; ++k)
                m->triangles[6 * (j * nx + i) + k] = corners[k];
        }
}

/* The mesh with cells of these sizes, in place of the one there was. */
static int32_t take_mesh(sillage_engine *engine, model *m, const sillage_sizes *sizes,
                         sillage_mesh *mesh)
{
    double count[2] = {1.0, 1.0};
    for (unsigned axis = 0; axis < 2; ++axis)
        for (uint64_t cell = 0; cell < m->cells[axis]; ++cell)
            count[axis] += parts(m, sizes, axis, cell);
    if (count[0] * count[1] > NODES_MAX) {
        char why[128];
        snprintf(why, sizeof why, "the sizes ask for %.3g nodes, at most %.3g are possible",
                 count[0] * count[1], NODES_MAX);
        return sillage_fail(engine, SILLAGE_FAILURE_ENGINE, why);
    }
    const uint64_t nx = (uint64_t)count[0] - 1, ny = (uint64_t)count[1] - 1;
    double *x = lines(m, sizes, 0, nx + 1), *y = lines(m, sizes, 1, ny + 1);
    free(m->node_position);
    free(m->triangles);
    m->node_position = malloc(2 * (nx + 1) * (ny + 1) * sizeof *m->node_position);
    m->triangles = malloc(6 * nx * ny * sizeof *m->triangles);
    const int enough = x && y && m->node_position && m->triangles;
    if (enough)
        fill_in(m, x, y, nx, ny);
    free(x);
    free(y);
    if (!enough)
        return sillage_fail(engine, SILLAGE_FAILURE_ENGINE, "no memory for the mesh");
    /* Corner coordinates and nodal masses are left to the library. */
    mesh->node_count = (nx + 1) * (ny + 1);
    mesh->node_position = m->node_position;
    mesh->simplex_count = 2 * nx * ny;
    mesh->simplex_nodes = m->triangles;
    return 0;
}

static int32_t configure(sillage_engine *engine, void *user, const sillage_fluid_scene *scene,
                         sillage_mesh *mesh)
{
    model *m = user;
    if (scene->dimension != 2)
        return sillage_fail(engine, SILLAGE_FAILURE_SCENE, "stream is for two dimensions");
    if (scene->mesh_file)
        return sillage_fail(engine, SILLAGE_FAILURE_SCENE, "stream takes rectangles, no mesh files");
    for (uint32_t b = 0; b < scene->boundary_count; ++b)
        if (scene->boundaries[b].condition == SILLAGE_PERIODIC)
            return sillage_fail(engine, SILLAGE_FAILURE_SCENE, "stream has no periodic sides");
    for (unsigned axis = 0; axis < 2; ++axis) {
        m->weight[axis] = scene->density * scene->gravity[axis];
        m->lower[axis] = scene->lower[axis];
        m->upper[axis] = scene->upper[axis];
        m->cells[axis] = scene->cells[axis];
    }
    return take_mesh(engine, m, scene->refinement, mesh);
}

/* Nothing is carried over: the stream is the same at every node there may be. A solver interpolates its
 * accepted state from the nodes of the mesh before. */
static int32_t adapt(sillage_engine *engine, void *user, const sillage_sizes *sizes, sillage_mesh *mesh)
{
    return take_mesh(engine, user, sizes, mesh);
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
    const sillage_fluid_calls calls = {
        .configure = configure, .advance = advance, .commit = commit, .adapt = adapt};
    model m = {0};
    int code = -1;
    if (argc == 3)
        for (unsigned axis = 0; axis < 2; ++axis)
            m.velocity[axis] = strtod(argv[1 + axis], NULL);
    sillage_engine *engine = sillage_engine_new("stream-c", "1.0");
    if (engine && sillage_abi_version() == SILLAGE_ABI_VERSION
        && sillage_engine_declare(engine, SILLAGE_ADAPTS) == 0)
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
