/* A particle engine in C: grains that fall under their weight and the fluid's drag, through each
 * other and through walls. Everything else that an engine owes is here: an accepted state and a
 * candidate, the implicit drag, failures in words, a checkpoint.
 *
 *     gcc -std=c11 -I engines/kit/c/include engines/kit/c/examples/falling.c \
 *         -L target/release -lsillage_engine -Wl,-rpath,$PWD/target/release -o falling
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sillage_engine.h"

typedef struct {
    size_t count;
    double gravity[2];
    double *mass, *fixed;
    /* 4 count numbers each: positions, then velocities. */
    double *accepted, *candidate;
} model;

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
    memcpy(m->gravity, scene->gravity, sizeof m->gravity);
    m->mass = copy_of(grains->mass, m->count);
    m->fixed = copy_of(grains->fixed, m->count);
    m->accepted = malloc((4 * m->count + 1) * sizeof *m->accepted);
    m->candidate = malloc((4 * m->count + 1) * sizeof *m->candidate);
    if (!m->mass || !m->fixed || !m->accepted || !m->candidate)
        return sillage_fail(engine, SILLAGE_FAILURE_ENGINE, "no memory for the grains");
    memcpy(m->accepted, grains->position, 2 * m->count * sizeof(double));
    memcpy(m->accepted + 2 * m->count, grains->velocity, 2 * m->count * sizeof(double));
    return 0;
}

static int32_t advance(sillage_engine *engine, void *user, const sillage_request *request,
                       const sillage_fluid_forces *fluid, const sillage_grain_answer *answer)
{
    model *m = user;
    const size_t n = 2 * m->count;
    const double dt = request->dt;
    double energy = 0.0;
    memcpy(m->candidate, m->accepted, 2 * n * sizeof(double));
    for (size_t k = 0; k < n; ++k) {
        double *x = &m->candidate[k], *v = &m->candidate[n + k];
        const double mass = m->mass[k / 2];
        const double drag = fluid->drag ? fluid->drag[k / 2] : 0.0;
        const double force = fluid->force ? fluid->force[k] : 0.0;
        answer->mean_velocity[k] = 0.0;
        if (m->fixed[k / 2] == 0.0) {
            /* (m + drag dt) v = m v_old + dt (m g + q): the drag at the end of the step */
            *v = (mass * *v + dt * (mass * m->gravity[k % 2] + force)) / (mass + dt * drag);
            *x += dt * *v;
            answer->mean_velocity[k] = *v;
            energy += 0.5 * mass * *v * *v;
        }
        answer->position[k] = *x;
        answer->velocity[k] = *v;
    }
    memset(answer->contact, 0, m->count * sizeof(double));
    return sillage_report(engine, "kinetic_energy", energy) == 0 && sillage_report(engine, "sub_steps", 1) == 0
               ? 0
               : sillage_fail(engine, SILLAGE_FAILURE_NOT_FINITE, sillage_last_error());
}

static int32_t commit(sillage_engine *engine, void *user)
{
    model *m = user;
    (void)engine;
    memcpy(m->accepted, m->candidate, 4 * m->count * sizeof(double));
    return 0;
}

static int32_t save(sillage_engine *engine, void *user, const char *path)
{
    const model *m = user;
    FILE *file = fopen(path, "wb");
    size_t written = file ? fwrite(m->accepted, sizeof(double), 4 * m->count, file) : 0;
    if (!file || fclose(file) != 0 || written != 4 * m->count)
        return sillage_fail(engine, SILLAGE_FAILURE_ENGINE, "the checkpoint cannot be written");
    return 0;
}

static int32_t restore(sillage_engine *engine, void *user, const char *path)
{
    model *m = user;
    FILE *file = fopen(path, "rb");
    /* One number more than there may be: a longer file is another run's. */
    double *numbers = malloc((4 * m->count + 1) * sizeof *numbers);
    size_t found = file && numbers ? fread(numbers, sizeof(double), 4 * m->count + 1, file) : 0;
    int32_t result = 0;
    if (found == 4 * m->count)
        memcpy(m->accepted, numbers, found * sizeof *numbers);
    else
        result = sillage_fail(engine, SILLAGE_FAILURE_ENGINE, "not a checkpoint of these grains");
    free(numbers);
    if (file)
        fclose(file);
    return result;
}

int main(void)
{
    const sillage_particle_calls calls = {configure, advance, commit, save, restore};
    model m = {0};
    sillage_engine *engine = sillage_engine_new("falling-c", "1.0");
    int code = -1;
    if (engine && sillage_abi_version() == SILLAGE_ABI_VERSION
        && sillage_engine_declare(engine, SILLAGE_IMPLICIT_DRAG) == 0
        && sillage_engine_declare(engine, SILLAGE_CHECKPOINT) == 0)
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
