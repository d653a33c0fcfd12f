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
    sillage_engine_free(engine);
    sillage_engine_free(NULL);
    printf("%d wrong\n", wrong);
    return wrong != 0;
}
