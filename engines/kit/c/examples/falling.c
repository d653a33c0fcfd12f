/* A particle engine in C: grains that fall under their weight and the fluid's drag, through each
 * other and through walls. Everything else that an engine owes is here: an accepted state and a
 * candidate, the implicit drag, failures in words, a checkpoint, grains that leave.
 *
 *     gcc -std=c11 -I engines/kit/c/include engines/kit/c/examples/falling.c \
 *         -L target/release -lsillage_engine -Wl,-rpath,$PWD/target/release -o falling
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sillage_engine.h"

typedef struct {
    size_t count, dimension;
    double gravity[3];
    double *mass, *fixed;
    /* Of each grain its position, then its velocity. */
    double *accepted, *candidate;
} model;

/* Numbers of a state. */
static size_t numbers(const model *m)
{
    return 2 * m->dimension * m->count;
}

static double *copy_of(const double *from, size_t count)
{
    double *copy = malloc((count + 1) * sizeof *copy);
    if (copy)
        memcpy(copy, from, count * sizeof *copy);
    return copy;
}

static int32_t configure(sillage_engine *engine, void *user, const sillage_particle_scene *scene,
                         sillage_grains *grains)
{
    model *m = user;
    m->count = grains->count;
    m->dimension = scene->dimension;
    memcpy(m->gravity, scene->gravity, m->dimension * sizeof *m->gravity);
    m->mass = copy_of(grains->mass, m->count);
    m->fixed = copy_of(grains->fixed, m->count);
    m->accepted = malloc((numbers(m) + 1) * sizeof *m->accepted);
    m->candidate = malloc((numbers(m) + 1) * sizeof *m->candidate);
    if (!m->mass || !m->fixed || !m->accepted || !m->candidate)
        return sillage_fail(engine, SILLAGE_FAILURE_ENGINE, "no memory for the grains");
    const size_t d = m->dimension;
    for (size_t k = 0; k < d * m->count; ++k) {
        double *x = &m->accepted[2 * d * (k / d) + k % d], *v = x + d;
        *x = grains->position[k];
        *v = grains->velocity[k];
    }
    return 0;
}

static int32_t advance(sillage_engine *engine, void *user, const sillage_request *request,
                       const sillage_inputs *inputs, const sillage_outputs *outputs,
                       sillage_particle_report *report)
{
    model *m = user;
    const size_t d = m->dimension;
    const double dt = request->dt;
    /* NULL: not sent, zero everywhere. */
    const double *gamma = sillage_input(inputs, SILLAGE_FIELD_GRAIN_DRAG);
    const double *q = sillage_input(inputs, SILLAGE_FIELD_GRAIN_FORCE);
    double *position = sillage_output(outputs, SILLAGE_FIELD_GRAIN_POSITION);
    double *velocity = sillage_output(outputs, SILLAGE_FIELD_GRAIN_VELOCITY);
    double *mean_velocity = sillage_output(outputs, SILLAGE_FIELD_GRAIN_MEAN_VELOCITY);
    double *contact = sillage_output(outputs, SILLAGE_FIELD_GRAIN_CONTACT);
    double energy = 0.0;
    memcpy(m->candidate, m->accepted, numbers(m) * sizeof(double));
    for (size_t k = 0; k < d * m->count; ++k) {
        double *x = &m->candidate[2 * d * (k / d) + k % d], *v = x + d;
        const double mass = m->mass[k / d];
        const double drag = gamma ? gamma[k / d] : 0.0;
        const double force = q ? q[k] : 0.0;
        mean_velocity[k] = 0.0;
        if (m->fixed[k / d] == 0.0) {
            /* (m + drag dt) v = m v_old + dt (m g + q): the drag at the end of the step */
            *v = (mass * *v + dt * (mass * m->gravity[k % d] + force)) / (mass + dt * drag);
            *x += dt * *v;
            mean_velocity[k] = *v;
            energy += 0.5 * mass * *v * *v;
        }
        position[k] = *x;
        velocity[k] = *v;
    }
    memset(contact, 0, m->count * sizeof(double));
    /* Every particle engine owes this one: the coupler goes by it. */
    report->sub_steps = 1;
    return sillage_diagnostic(engine, "kinetic_energy", energy) == 0
               ? 0
               : sillage_fail(engine, SILLAGE_FAILURE_NOT_FINITE, sillage_last_error());
}

static int32_t commit(sillage_engine *engine, void *user)
{
    model *m = user;
    (void)engine;
    memcpy(m->accepted, m->candidate, numbers(m) * sizeof(double));
    return 0;
}

static int32_t save(sillage_engine *engine, void *user, const char *path)
{
    const model *m = user;
    FILE *file = fopen(path, "wb");
    size_t written = file ? fwrite(m->accepted, sizeof(double), numbers(m), file) : 0;
    if (!file || fclose(file) != 0 || written != numbers(m))
        return sillage_fail(engine, SILLAGE_FAILURE_ENGINE, "the checkpoint cannot be written");
    return 0;
}

static int32_t restore(sillage_engine *engine, void *user, const char *path)
{
    model *m = user;
    FILE *file = fopen(path, "rb");
    /* One number more than there may be: a longer file is another run's. */
    double *state = malloc((numbers(m) + 1) * sizeof *state);
    size_t found = file && state ? fread(state, sizeof(double), numbers(m) + 1, file) : 0;
    int32_t result = 0;
    if (found == numbers(m))
        memcpy(m->accepted, state, found * sizeof *state);
    else
        result = sillage_fail(engine, SILLAGE_FAILURE_ENGINE, "not a checkpoint of these grains");
    free(state);
    if (file)
        fclose(file);
    return result;
}

/* Grains leave: the others move up, in their order. */
static int32_t leave(sillage_engine *engine, void *user, const uint64_t *gone, uint64_t gone_count,
                     sillage_grains *left)
{
    model *m = user;
    const size_t d = m->dimension;
    size_t kept = 0;
    (void)engine;
    for (size_t grain = 0, next = 0; grain < m->count; ++grain) {
        if (next < gone_count && gone[next] == grain) {
            ++next;
            continue;
        }
        m->mass[kept] = m->mass[grain];
        m->fixed[kept] = m->fixed[grain];
        memmove(&m->accepted[2 * d * kept], &m->accepted[2 * d * grain], 2 * d * sizeof(double));
        /* The library knows all but where they are and how they move. */
        memcpy(&left->position[d * kept], &m->accepted[2 * d * kept], d * sizeof(double));
        memcpy(&left->velocity[d * kept], &m->accepted[2 * d * kept + d], d * sizeof(double));
        ++kept;
    }
    m->count = kept;
    return 0;
}

int main(void)
{
    const sillage_particle_calls calls = {configure, advance, commit, save, restore, leave};
    model m = {0};
    sillage_engine *engine = sillage_engine_new("falling-c", "1.0");
    int code = -1;
    if (engine && sillage_abi_version() == SILLAGE_ABI_VERSION
        && sillage_engine_declare(engine, SILLAGE_IMPLICIT_DRAG) == 0
        && sillage_engine_declare(engine, SILLAGE_CHECKPOINT) == 0
        && sillage_engine_declare(engine, SILLAGE_REMOVES_GRAINS) == 0)
        code = sillage_run_particles(engine, &calls, &m);
    if (code < 0) {
        fprintf(stderr, "falling: %s\n", sillage_last_error());
        code = 4;
    }
    sillage_engine_free(engine);
    free(m.mass);
    free(m.fixed);
    free(m.accepted);
    free(m.candidate);
    return code;
}
