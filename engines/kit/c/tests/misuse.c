/* Wrong calls are refused in words, on the thread that made them. */
#include <pthread.h>
#include <stdio.h>
#include <string.h>

#include "sillage_engine.h"

static int wrong = 0;

static void must(int holds, const char *what)
{
    printf("%-4s %s: %s\n", holds ? "ok" : "BAD", what, sillage_last_error());
    wrong += !holds;
}

static int says(const char *words)
{
    return strstr(sillage_last_error(), words) != NULL;
}

static int32_t nothing(sillage_engine *engine, void *user)
{
    (void)engine, (void)user;
    return 0;
}

static int32_t configure(sillage_engine *engine, void *user, const sillage_particle_scene *scene,
                         sillage_grains *grains)
{
    (void)engine, (void)user, (void)scene, (void)grains;
    return 0;
}

static int32_t configure_fluid(sillage_engine *engine, void *user, const sillage_fluid_scene *scene,
                               sillage_mesh *mesh)
{
    (void)engine, (void)user, (void)scene, (void)mesh;
    return 0;
}

static int32_t advance(sillage_engine *engine, void *user, const sillage_request *request,
                       const sillage_inputs *inputs, const sillage_outputs *outputs,
                       sillage_particle_report *report)
{
    (void)engine, (void)user, (void)request, (void)inputs, (void)outputs, (void)report;
    return 0;
}

static int32_t advance_fluid(sillage_engine *engine, void *user, const sillage_request *request,
                             const sillage_inputs *inputs, const sillage_outputs *outputs,
                             sillage_fluid_report *report)
{
    (void)engine, (void)user, (void)request, (void)inputs, (void)outputs, (void)report;
    return 0;
}

static void *other_thread(void *unused)
{
    (void)unused;
    must(sillage_last_error()[0] == '\0', "another thread has no error of ours");
    must(sillage_engine_new("", "1") == NULL && says("must not be empty"), "empty name");
    return NULL;
}

int main(void)
{
    pthread_t thread;
    must(sillage_engine_new(NULL, "1") == NULL && says("name is a null pointer"), "no name");
    must(sillage_engine_new("\xff", "1") == NULL && says("not UTF-8"), "name not UTF-8");
    pthread_create(&thread, NULL, other_thread, NULL);
    pthread_join(thread, NULL);
    must(says("not UTF-8"), "the error of this thread is kept");
    must(sillage_engine_declare(NULL, 0) == -1 && says("engine is a null pointer"), "no engine");
    sillage_engine *engine = sillage_engine_new("misuse", "1");
    must(engine != NULL, "an engine");
    must(sillage_engine_declare(engine, 9) == -1 && says("capability 9"), "unknown capability");
    must(sillage_diagnostic(engine, "x", 0.0 / 0.0) == -1 && says("must be finite"), "NaN reported");
    must(sillage_diagnostic(engine, NULL, 1.0) == -1 && says("name is a null"), "report without name");
    must(sillage_fail(engine, 99, "odd") != 0, "an unknown kind still fails");
    must(sillage_fail(engine, SILLAGE_FAILURE_ENGINE, NULL) == 4, "no reason still fails");
    must(sillage_run_particles(engine, NULL, NULL) == -1 && says("calls is a null"), "no calls");
    sillage_particle_calls calls = {0};
    must(sillage_run_particles(engine, &calls, NULL) == -1 && says("calls.configure"), "no function");
    sillage_engine_declare(engine, SILLAGE_CHECKPOINT);
    sillage_fluid_calls fluid = {0};
    fluid.commit = nothing;
    must(sillage_run_fluid(engine, &fluid, NULL) == -1 && says("calls.configure"), "no function");
    fluid.configure = configure_fluid;
    must(sillage_run_fluid(engine, &fluid, NULL) == -1 && says("calls.advance"), "no advance");
    fluid.advance = advance_fluid;
    must(sillage_run_fluid(engine, &fluid, NULL) == -1 && says("calls.save"), "no save");
    sillage_engine_free(engine);
    engine = sillage_engine_new("misuse", "1");
    must(sillage_engine_declare(engine, SILLAGE_ADAPTS) == 0, "declared");
    must(sillage_run_fluid(engine, &fluid, NULL) == -1 && says("calls.adapt"), "no adapt");
    sillage_engine_free(engine);
    engine = sillage_engine_new("misuse", "1");
    must(sillage_engine_declare(engine, SILLAGE_REMOVES_GRAINS) == 0, "declared");
    calls.configure = configure, calls.advance = advance, calls.commit = nothing;
    must(sillage_run_particles(engine, &calls, NULL) == -1 && says("calls.remove"), "no remove");
    sillage_engine_free(engine);
    sillage_engine_free(NULL);
    printf("%d wrong\n", wrong);
    return wrong != 0;
}
