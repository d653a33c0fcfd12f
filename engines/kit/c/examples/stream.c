/* A fluid engine in C: a uniform stream that nothing disturbs, on a rectangle of triangles or a box of
 * tetrahedra whose lines lie as close as the scene, or the coupler between two steps, asks for.
 *
 *     stream VX VY [VZ]        interstitial velocity (m/s)
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "sillage_engine.h"

/* Larger meshes are refused. */
#define NODES_MAX 4000000.0

typedef struct {
    size_t dimension;
    double velocity[3];
    double weight[3]; /* density times gravity (N/m3) */
    /* The rectangle or box (m), and its cells where nothing smaller is asked for. */
    double lower[3], upper[3];
    uint64_t cells[3];
    double *node_position;
    uint32_t *simplices;
} model;

/* Orders of the axes, each one exchange from the one before; the first two are those of the plane. */
static const unsigned ORDERS[6][3] = {{0, 1, 2}, {1, 0, 2}, {1, 2, 0}, {2, 1, 0}, {2, 0, 1}, {0, 2, 1}};

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

/* Where a line of the rectangle or box as the scene has it lies (m). */
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

/* Nodes along x, then y, then z. A cell of d axes is cut into d! simplices: from its lowest corner along
 * the axes in each of their orders (Kuhn), every second of which is left-handed and turned around. */
static void fill_in(model *m, double *const at[3], const uint64_t count[3])
{
    const size_t d = m->dimension, orders = d == 2 ? 2 : 6;
    uint64_t stride[3] = {0}, nodes = 1, cells = 1;
    for (size_t axis = 0; axis < d; ++axis) {
        stride[axis] = nodes;
        nodes *= count[axis] + 1;
        cells *= count[axis];
    }
    for (uint64_t node = 0; node < nodes; ++node)
        for (size_t axis = 0; axis < d; ++axis)
            m->node_position[d * node + axis] = at[axis][node / stride[axis] % (count[axis] + 1)];
    for (uint64_t cell = 0; cell < cells; ++cell) {
        uint64_t lowest = 0, rest = cell;
        for (size_t axis = 0; axis < d; ++axis) {
            lowest += rest % count[axis] * stride[axis];
            rest /= count[axis];
        }
        for (size_t order = 0; order < orders; ++order) {
            uint32_t *corner = &m->simplices[(d + 1) * (orders * cell + order)];
            uint64_t node = lowest;
            corner[0] = (uint32_t)node;
            for (size_t k = 0; k < d; ++k) {
                node += stride[ORDERS[order][k]];
                corner[k + 1] = (uint32_t)node;
            }
            if (order % 2 == 1) {
                corner[d] = corner[d - 1];
                corner[d - 1] = (uint32_t)node;
            }
        }
    }
}

/* The mesh with cells of these sizes, in place of the one there was. */
static int32_t take_mesh(sillage_engine *engine, model *m, const sillage_sizes *sizes,
                         sillage_mesh *mesh)
{
    const size_t d = m->dimension;
    double nodes = 1.0, count[3] = {1.0, 1.0, 1.0};
    for (unsigned axis = 0; axis < d; ++axis) {
        for (uint64_t cell = 0; cell < m->cells[axis]; ++cell)
            count[axis] += parts(m, sizes, axis, cell);
        nodes *= count[axis];
    }
    if (nodes > NODES_MAX) {
        char why[128];
        snprintf(why, sizeof why, "the sizes ask for %.3g nodes, at most %.3g are possible", nodes,
                 NODES_MAX);
        return sillage_fail(engine, SILLAGE_FAILURE_ENGINE, why);
    }
    double *at[3] = {NULL, NULL, NULL};
    uint64_t cut[3] = {0}, simplices = d == 2 ? 2 : 6;
    int enough = 1;
    for (unsigned axis = 0; axis < d; ++axis) {
        cut[axis] = (uint64_t)count[axis] - 1;
        simplices *= cut[axis];
        at[axis] = lines(m, sizes, axis, cut[axis] + 1);
        enough = enough && at[axis];
    }
    free(m->node_position);
    free(m->simplices);
    m->node_position = malloc(d * (uint64_t)nodes * sizeof *m->node_position);
    m->simplices = malloc((d + 1) * simplices * sizeof *m->simplices);
    enough = enough && m->node_position && m->simplices;
    if (enough)
        fill_in(m, at, cut);
    for (unsigned axis = 0; axis < d; ++axis)
        free(at[axis]);
    if (!enough)
        return sillage_fail(engine, SILLAGE_FAILURE_ENGINE, "no memory for the mesh");
    /* Corner coordinates and nodal masses are left to the library. */
    mesh->node_count = (uint64_t)nodes;
    mesh->node_position = m->node_position;
    mesh->simplex_count = simplices;
    mesh->simplex_nodes = m->simplices;
    return 0;
}

static int32_t configure(sillage_engine *engine, void *user, const sillage_fluid_scene *scene,
                         sillage_mesh *mesh)
{
    model *m = user;
    if (scene->mesh_file)
        return sillage_fail(engine, SILLAGE_FAILURE_SCENE,
                            "stream takes rectangles and boxes, no mesh files");
    for (uint32_t b = 0; b < scene->boundary_count; ++b)
        if (scene->boundaries[b].condition == SILLAGE_PERIODIC)
            return sillage_fail(engine, SILLAGE_FAILURE_SCENE, "stream has no periodic sides");
    m->dimension = scene->dimension;
    for (unsigned axis = 0; axis < m->dimension; ++axis) {
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
    const size_t d = m->dimension;
    for (uint64_t node = 0; node < request->count; ++node) {
        pressure[node] = 0.0;
        for (size_t axis = 0; axis < d; ++axis) {
            velocity[d * node + axis] = m->velocity[axis];
            gradient[d * node + axis] = m->weight[axis];
            pressure[node] += m->weight[axis] * m->node_position[d * node + axis];
        }
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
    for (int axis = 0; axis < 3 && axis + 1 < argc; ++axis)
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
    free(m.simplices);
    return code;
}
