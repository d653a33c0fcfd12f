/* The C interface of Sillage's engines. Written by cbindgen from engines/kit/c/src: do not edit.
 *
 * An engine makes a handle, says what it can do, and hands over its functions:
 *
 *     sillage_engine *engine = sillage_engine_new("my-engine", "1.0");
 *     sillage_engine_declare(engine, SILLAGE_IMPLICIT_DRAG);
 *     int code = sillage_run_particles(engine, &calls, user);
 *     sillage_engine_free(engine);
 *     return code;
 *
 * Units are SI. One engine may serve the plane and space: d, 2 or 3, is the scene's `dimension`.
 *
 *     vectors     d numbers each, interleaved: x0, y0, x1, y1, ... or x0, y0, z0, x1, y1, z1, ...
 *     spins       angular velocities: 1 number in the plane (counter-clockwise), a vector of 3 in space
 *     simplices   d + 1 corners: triangles of 3 nodes, tetrahedra of 4
 *     walls       d corners: segments, triangles
 *     grains      disks, per metre of depth; spheres
 *
 * Memory. Everything that the library hands to a function of the engine belongs to the library and
 * is valid until that function returns. What an engine hands to the library is copied before the
 * call returns (the mesh: when `configure` or `adapt` has returned, right after it).
 *
 * Errors. Functions return 0, or -1 with the reason in sillage_last_error(), which is kept for
 * each thread. Functions of the engine return 0, or what sillage_fail() returned.
 *
 * Threads. The engine's functions are called one after the other on the thread that called
 * sillage_run_...; sillage_fail() and sillage_diagnostic() may be called from any thread. No C++
 * exception and no longjmp may leave a function of the engine: the process would abort.
 *
 * Signals. sillage_run_...() sets handlers for SIGTERM, SIGHUP, SIGINT (leave the run, exit with 128 +
 * the signal) and SIGBUS (shared memory is full: a line on stderr, exit code 4), and a thread that ends
 * the process with exit code 5 when a partner is lost during a long computation.
 */


#ifndef SILLAGE_ENGINE_H
#define SILLAGE_ENGINE_H

#include <stdint.h>

/*
 Porosity φ. (–; scalar)
 */
#define SILLAGE_FIELD_POROSITY 10

/*
 Drag coefficient β per volume of the mixture. (kg/(m³ s); scalar)
 */
#define SILLAGE_FIELD_DRAG 11

/*
 Drag source s. (N/m³; vector)
 */
#define SILLAGE_FIELD_DRAG_SOURCE 12

/*
 Entrained solid fraction c. (–; scalar)
 */
#define SILLAGE_FIELD_ENTRAINED_FRACTION 13

/*
 Solid flux j⁰. (m/s; vector)
 */
#define SILLAGE_FIELD_SOLID_FLUX 14

/*
 Solid mobility κ. (m³ s/kg; scalar)
 */
#define SILLAGE_FIELD_SOLID_MOBILITY 15

/*
 Interstitial velocity v_α = u_α/φ_α. (m/s; vector)
 */
#define SILLAGE_FIELD_INTERSTITIAL_VELOCITY 20

/*
 Pressure gradient ℓ_α⁻¹ ∫N_α ∇p. (Pa/m; vector)
 */
#define SILLAGE_FIELD_PRESSURE_GRADIENT 21

/*
 Pressure p. (Pa; scalar)
 */
#define SILLAGE_FIELD_PRESSURE 22

/*
 Centres. (m; vector)
 */
#define SILLAGE_FIELD_GRAIN_POSITION 30

/*
 Velocities, of the end of the step. (m/s; vector)
 */
#define SILLAGE_FIELD_GRAIN_VELOCITY 31

/*
 (xⁿ⁺¹ − xⁿ)/Δt, before wrapping. (m/s; vector)
 */
#define SILLAGE_FIELD_GRAIN_MEAN_VELOCITY 32

/*
 Angular velocities of the end of the step, in the plane counter-clockwise; 0 before the first. (rad/s; spin)
 */
#define SILLAGE_FIELD_GRAIN_SPIN 37

/*
 Drag coefficient γ, constant over the step, taken implicitly. (kg/s; scalar)
 */
#define SILLAGE_FIELD_GRAIN_DRAG 40

/*
 Force q = γ v_f − V∇p, which does not depend on the grain's velocity. (N; vector)
 */
#define SILLAGE_FIELD_GRAIN_FORCE 41

/*
 0 free, 1 touches, 2 held by a wall or a fixed grain. (–; scalar)
 */
#define SILLAGE_FIELD_GRAIN_CONTACT 42

/*
 Part of `drag` that is of fixed grains; at most `drag`. (kg/(m³ s); scalar)
 */
#define SILLAGE_FIELD_FIXED_DRAG 50


/*
 Version of this interface; compare with sillage_abi_version().
 */
#define SILLAGE_ABI_VERSION 3

/*
 Fluid: the entrained fraction and the solid mobility are used, not only drag and source.
 */
#define SILLAGE_AFFINE_RESPONSE 0

/*
 Particles: the drag is taken implicitly, in the free motion and in the contacts.
 */
#define SILLAGE_IMPLICIT_DRAG 1

/*
 Particles: contact 2 tells grains that a wall or a fixed grain holds.
 */
#define SILLAGE_CONTACT_STATE 2

/*
 Both: save and restore bring back the same bits.
 */
#define SILLAGE_CHECKPOINT 3

/*
 Particles: every candidate has the spins.
 */
#define SILLAGE_SPIN 4

/*
 Particles: remove() is there; a scene that grains may leave is refused without it.
 */
#define SILLAGE_REMOVES_GRAINS 5

/*
 Fluid: goes by `refinement` of its scene, and adapt() is there; such a scene is refused without it.
 */
#define SILLAGE_ADAPTS 6

/*
 The scene's part is not usable (exit code 2).
 */
#define SILLAGE_FAILURE_SCENE 2

/*
 The engine cannot do this, or broke (exit code 4).
 */
#define SILLAGE_FAILURE_ENGINE 4

/*
 A value is not finite, or an invariant is broken (exit code 7).
 */
#define SILLAGE_FAILURE_NOT_FINITE 7

/*
 An iteration did not converge (exit code 8).
 */
#define SILLAGE_FAILURE_NOT_CONVERGED 8

/*
 Boundary: u = 0.
 */
#define SILLAGE_NO_SLIP 0

/*
 Boundary: u.n = 0, no tangential traction.
 */
#define SILLAGE_SLIP 1

/*
 Boundary: joined with the opposite side.
 */
#define SILLAGE_PERIODIC 2

/*
 Boundary: superficial velocity given, the same everywhere.
 */
#define SILLAGE_INFLOW_UNIFORM 3

/*
 Boundary: superficial velocity given, zero at both ends and `velocity` in the middle.
 */
#define SILLAGE_INFLOW_PARABOLIC 4

/*
 Boundary: pressure given at its highest point, hydrostatic along it.
 */
#define SILLAGE_OPEN 5

/*
 Boundary: a wall that moves along itself, u = velocity.
 */
#define SILLAGE_MOVING_WALL 6

/*
 Time scheme: backward Euler.
 */
#define SILLAGE_BACKWARD_EULER 0

/*
 Time scheme: second order, the first step backward Euler.
 */
#define SILLAGE_BDF2 1

/*
 Time scheme: one advance() is the steady state.
 */
#define SILLAGE_STEADY 2

/*
 An engine: made by sillage_engine_new(), freed by sillage_engine_free().
 */
typedef struct sillage_engine sillage_engine;

/*
 Fields that came with a request; valid until advance() returns.
 */
typedef struct sillage_inputs sillage_inputs;

/*
 Fields of the candidate, to be filled; valid until advance() returns.
 */
typedef struct sillage_outputs sillage_outputs;

/*
 The condition on a named boundary. Velocities are superficial.
 */
typedef struct sillage_boundary {
    /*
     Its name: left, right, bottom, top of a rectangle or box, back, front of a box, or the mesh's.
     */
    const char *name;
    /*
     One of SILLAGE_NO_SLIP, SILLAGE_SLIP, SILLAGE_PERIODIC, SILLAGE_INFLOW_UNIFORM,
     SILLAGE_INFLOW_PARABOLIC, SILLAGE_OPEN, SILLAGE_MOVING_WALL.
     */
    uint32_t condition;
    /*
     Velocity of an inflow or a moving wall (m/s), `dimension` numbers; NULL where there is none.
     */
    const double *velocity;
    /*
     Pressure of an open boundary (Pa).
     */
    double pressure;
} sillage_boundary;

/*
 A place where cells are small: all that is within `radius` of the box from `lower` to `upper`. A ball
 has its centre in both.
 */
typedef struct sillage_region {
    /*
     Lower corner (m), a vector.
     */
    const double *lower;
    /*
     Upper corner (m), a vector.
     */
    const double *upper;
    /*
     How far it reaches around the box (m).
     */
    double radius;
    /*
     Cells in it (m).
     */
    double size;
} sillage_region;

/*
 How large cells are to be at x (m): h(x) is the smallest of `largest` and, for each region, of its
 `size` + `growth` times the distance of x from it, along a period from its nearest image. All numbers are
 in range.
 */
typedef struct sillage_sizes {
    /*
     Dimension of the space: a vector has as many numbers.
     */
    uint32_t dimension;
    /*
     Number of regions, at most 512.
     */
    uint32_t region_count;
    /*
     Regions.
     */
    const struct sillage_region *regions;
    /*
     By how much cells grow away from a region, in metres a metre.
     */
    double growth;
    /*
     Largest cells (m); INFINITY: those that the scene's mesh has.
     */
    double largest;
} sillage_sizes;

/*
 What a fluid engine is configured with. Vectors have `dimension` numbers.
 */
typedef struct sillage_fluid_scene {
    /*
     Dimension of the space, 2 or 3. An engine that cannot do it fails with SILLAGE_FAILURE_SCENE.
     */
    uint32_t dimension;
    /*
     Number of boundaries.
     */
    uint32_t boundary_count;
    /*
     Boundaries.
     */
    const struct sillage_boundary *boundaries;
    /*
     Density (kg/m3).
     */
    double density;
    /*
     Dynamic viscosity (Pa s).
     */
    double dynamic_viscosity;
    /*
     g (m/s2), a vector.
     */
    const double *gravity;
    /*
     A Gmsh file, 2.2 or 4.1, ASCII or binary; NULL: a rectangle, in space a box. See `mesh_scale` and `mesh_surfaces`.
     */
    const char *mesh_file;
    /*
     Rectangle or box: corner with the lowest coordinates (m), a vector; NULL with a file.
     */
    const double *lower;
    /*
     Rectangle or box: corner with the highest coordinates (m), a vector; NULL with a file.
     */
    const double *upper;
    /*
     Rectangle or box: cells along each axis, two triangles or six tetrahedra each; NULL with a file.
     */
    const uint64_t *cells;
    /*
     Rectangle: ratio of the largest to the smallest cell along each axis, both ends refined; a box has
     1; NULL with a file.
     */
    const double *grading;
    /*
     Rectangle: 0: diagonals alternate from cell to cell, 1: all the same, as in a box.
     */
    uint32_t uniform_diagonals;
    /*
     0: creeping flow, no v.grad v.
     */
    uint32_t convection;
    /*
     One of SILLAGE_BACKWARD_EULER, SILLAGE_BDF2, SILLAGE_STEADY.
     */
    uint32_t time_scheme;
    /*
     0: -div(2 mu phi D(v)), 1: the paper's three terms as printed.
     */
    uint32_t paper_literal_viscosity;
    /*
     Newton to this relative residual within a step; 0: one linear solve.
     */
    double newton_tolerance;
    /*
     Iterations of Newton allowed.
     */
    uint64_t newton_iterations_max;
    /*
     Factor of a grad-div stabilisation.
     */
    double grad_div;
    /*
     Uniform initial superficial velocity (m/s), a vector.
     */
    const double *initial_velocity;
    /*
     Threads the engine may use.
     */
    uint32_t threads;
    /*
     Number of surfaces; 0: the file has one.
     */
    uint32_t mesh_surface_count;
    /*
     Surfaces of the file that are filled, by name or number.
     */
    const char *const *mesh_surfaces;
    /*
     Metres of a unit of the file.
     */
    double mesh_scale;
    /*
     How large the cells of the first mesh are to be; NULL: as they stand here. Only where
     SILLAGE_ADAPTS is declared.
     */
    const struct sillage_sizes *refinement;
} sillage_fluid_scene;

/*
 The mesh, to be filled by configure() and adapt(): pointers to the engine's arrays, which must outlive
 the call and are copied right after it. Every pointer is NULL and every count 0 before. d is the
 scene's dimension.
 */
typedef struct sillage_mesh {
    /*
     Number of nodes.
     */
    uint64_t node_count;
    /*
     Node coordinates (m), d node_count numbers.
     */
    const double *node_position;
    /*
     Number of simplices: triangles in the plane, tetrahedra in space.
     */
    uint64_t simplex_count;
    /*
     Nodes of each simplex, (d + 1) simplex_count numbers, positively oriented: in the plane
     counter-clockwise, in space so that (x1 - x0) x (x2 - x0) points to the side of x3.
     */
    const uint32_t *simplex_nodes;
    /*
     Coordinates of each simplex's corners (m), unwrapped across periodic sides, d (d + 1)
     simplex_count numbers; NULL: those of its nodes.
     */
    const double *simplex_position;
    /*
     Integral of each node's shape function (m2; in space m3); NULL: an equal share of its simplices.
     */
    const double *nodal_mass;
    /*
     Period along each axis (m), d numbers, 0 where there is none; NULL: not periodic.
     */
    const double *period;
} sillage_mesh;

/*
 What is asked of one advance().
 */
typedef struct sillage_request {
    /*
     Step, from 1.
     */
    uint64_t step;
    /*
     Pass within the step, from 0; a new pass throws the previous candidate away.
     */
    uint32_t pass;
    /*
     Particles: number of sub-steps to use; 0: the engine chooses.
     */
    uint32_t sub_steps;
    /*
     Time at the start of the step (s).
     */
    double time;
    /*
     Length of the step (s).
     */
    double dt;
    /*
     Relative accuracy asked of an inexact solve (contact): of |g| dt.
     */
    double tolerance;
    /*
     Number of nodes or grains.
     */
    uint64_t count;
    /*
     Dimension of the space: a vector has as many numbers.
     */
    uint32_t dimension;
} sillage_request;

/*
 What a fluid engine tells of a candidate. All may be left as they are: not known.
 */
typedef struct sillage_fluid_report {
    /*
     Power of the solid's terms as the equations had them (W; in the plane W/m); NaN before.
     */
    double solid_power;
    /*
     Reynolds number by which the engine judges whether convection matters; NaN before.
     */
    double reynolds;
    /*
     Was v.grad v in the equations? 0, 1; -1 before.
     */
    int32_t convects;
} sillage_fluid_report;

/*
 The functions of a fluid engine. Each returns 0, or what sillage_fail() returned. `user` is what
 was given to sillage_run_fluid(). `save` and `restore` may be NULL where SILLAGE_CHECKPOINT is not
 declared, `adapt` where SILLAGE_ADAPTS is not; the others may not.
 */
typedef struct sillage_fluid_calls {
    /*
     Take the scene, build the mesh, fill it in.
     */
    int32_t (*configure)(struct sillage_engine *engine,
                         void *user,
                         const struct sillage_fluid_scene *scene,
                         struct sillage_mesh *mesh);
    /*
     Compute a candidate from the accepted state, which must not change.
     */
    int32_t (*advance)(struct sillage_engine *engine,
                       void *user,
                       const struct sillage_request *request,
                       const struct sillage_inputs *inputs,
                       const struct sillage_outputs *outputs,
                       struct sillage_fluid_report *report);
    /*
     The last candidate becomes the accepted state.
     */
    int32_t (*commit)(struct sillage_engine *engine, void *user);
    /*
     Write the accepted state to a file.
     */
    int32_t (*save)(struct sillage_engine *engine, void *user, const char *path);
    /*
     Read the accepted state from a file.
     */
    int32_t (*restore)(struct sillage_engine *engine, void *user, const char *path);
    /*
     Before a step: change to a mesh with cells of these sizes, in place of all asked for before, carry
     the accepted state over to it, and fill it in as in configure(). The mesh must depend on the
     sizes and the scene alone, not on the meshes before. A mesh that is left as it was given: the
     engine keeps the one it has.
     */
    int32_t (*adapt)(struct sillage_engine *engine,
                     void *user,
                     const struct sillage_sizes *sizes,
                     struct sillage_mesh *mesh);
} sillage_fluid_calls;

/*
 What a particle engine is configured with.
 */
typedef struct sillage_particle_scene {
    /*
     Dimension d of the space, 2 or 3. An engine that cannot do it fails with SILLAGE_FAILURE_SCENE.
     */
    uint32_t dimension;
    /*
     Threads the engine may use.
     */
    uint32_t threads;
    /*
     g (m/s2), d numbers; the engine applies the whole weight m g.
     */
    const double *gravity;
    /*
     Period along each axis (m), d numbers; 0: not periodic.
     */
    const double *period;
    /*
     Number of walls.
     */
    uint64_t wall_count;
    /*
     Walls (m): d corners each, of d numbers. In the plane a segment from its first to its second
     corner: grains stay on the left of it, and off both ends. In space a triangle: grains stay on the
     side from which its corners are seen clockwise, and off its edges.
     */
    const double *walls;
    /*
     Coulomb coefficient between grains.
     */
    double friction;
    /*
     Coulomb coefficient between grains and walls.
     */
    double wall_friction;
    /*
     Moment of inertia over m r2: 1/2 for disks, 2/5 for spheres.
     */
    double inertia_factor;
    /*
     Contact residual at which a solve stops, relative to |g| dt.
     */
    double tolerance;
    /*
     Sweeps allowed; more is an error.
     */
    uint64_t sweeps_max;
    /*
     Sub-steps allowed in a step; more is an error.
     */
    uint32_t sub_steps_max;
} sillage_particle_scene;

/*
 The grains when a run begins, or those that are left when others have gone. The arrays stay the
 library's. In configure() the engine may change the numbers, and lower `count` to run the first ones
 only.
 */
typedef struct sillage_grains {
    /*
     Number of grains.
     */
    uint64_t count;
    /*
     Centres (m), d count numbers.
     */
    double *position;
    /*
     Velocities (m/s), d count numbers.
     */
    double *velocity;
    /*
     Radii (m), of disks or spheres.
     */
    double *radius;
    /*
     Masses (kg; disks: kg per metre of depth).
     */
    double *mass;
    /*
     Volumes (m3; disks: m2).
     */
    double *volume;
    /*
     1 for a grain that never moves, else 0.
     */
    double *fixed;
} sillage_grains;

/*
 What a particle engine tells of a candidate.
 */
typedef struct sillage_particle_report {
    /*
     Sub-steps that were taken: 0 before, which is refused, so it must be set.
     */
    uint32_t sub_steps;
    /*
     Contacts that carry an impulse; -1 before: not known.
     */
    int64_t touching;
} sillage_particle_report;

/*
 The functions of a particle engine. Each returns 0, or what sillage_fail() returned. `user` is
 what was given to sillage_run_particles(). `save` and `restore` may be NULL where
 SILLAGE_CHECKPOINT is not declared, `remove` where SILLAGE_REMOVES_GRAINS is not; the others may not.
 */
typedef struct sillage_particle_calls {
    /*
     Take the scene and the grains.
     */
    int32_t (*configure)(struct sillage_engine *engine,
                         void *user,
                         const struct sillage_particle_scene *scene,
                         struct sillage_grains *grains);
    /*
     Compute a candidate from the accepted state, which must not change.
     */
    int32_t (*advance)(struct sillage_engine *engine,
                       void *user,
                       const struct sillage_request *request,
                       const struct sillage_inputs *inputs,
                       const struct sillage_outputs *outputs,
                       struct sillage_particle_report *report);
    /*
     The last candidate becomes the accepted state.
     */
    int32_t (*commit)(struct sillage_engine *engine, void *user);
    /*
     Write the accepted state to a file.
     */
    int32_t (*save)(struct sillage_engine *engine, void *user, const char *path);
    /*
     Read the accepted state from a file.
     */
    int32_t (*restore)(struct sillage_engine *engine, void *user, const char *path);
    /*
     Before a step: take `gone_count` grains out of the accepted state, by their numbers in the present
     order, ascending. The others keep their order; tell them in `left`, which has them already but for
     their positions and velocities in the accepted state, which are NaN before.
     */
    int32_t (*remove)(struct sillage_engine *engine,
                      void *user,
                      const uint64_t *gone,
                      uint64_t gone_count,
                      struct sillage_grains *left);
} sillage_particle_calls;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 The numbers of an input, one of SILLAGE_FIELD_...: a scalar has `count` numbers, a vector
 `count * dimension`. NULL: it was not sent, and is 0 everywhere (porosity: 1).

 # Safety

 `inputs` is what advance() was called with, and advance() has not returned.
 */
const double *sillage_input(const struct sillage_inputs *inputs, uint32_t field);

/*
 Room for a field of the candidate, one of SILLAGE_FIELD_...: every number is NaN before, and refused
 if it stays so. NULL: this field is not of a candidate. Particles fill SILLAGE_FIELD_GRAIN_POSITION,
 _VELOCITY, _MEAN_VELOCITY and _CONTACT, a fluid SILLAGE_FIELD_INTERSTITIAL_VELOCITY,
 _PRESSURE_GRADIENT and _PRESSURE.

 # Safety

 `outputs` is what advance() was called with, and advance() has not returned.
 */
double *sillage_output(const struct sillage_outputs *outputs,
                       uint32_t field);

/*
 Take the fluid seat of the run that the environment names, serve the coupler until the run is
 over, and return the exit code for the process (0, or 2 to 8: protocol/README.md); -1 when the
 arguments are not usable. Blocks. To be called once in a process, from its first thread, before
 others are started.

 # Safety

 `engine` came from sillage_engine_new() and is not freed before this returns; `calls` points to
 functions that keep what this header says; `user` is passed on untouched.
 */
int32_t sillage_run_fluid(struct sillage_engine *engine,
                          const struct sillage_fluid_calls *calls,
                          void *user);

/*
 Version of the interface that the library has; an engine was built for SILLAGE_ABI_VERSION.
 */
uint32_t sillage_abi_version(void);

/*
 Make an engine's handle. `name` and `version` are for the handshake: UTF-8, not empty, copied.
 Returns NULL when they are not usable. Free it with sillage_engine_free().

 # Safety

 `name` and `version` are NULL or end with a zero byte.
 */
struct sillage_engine *sillage_engine_new(const char *name, const char *version);

/*
 Free a handle; NULL is allowed. Not while it runs.

 # Safety

 `engine` is NULL or came from sillage_engine_new(), is not freed yet, and does not run.
 */
void sillage_engine_free(struct sillage_engine *engine);

/*
 Declare what the engine can do, before it runs: one of SILLAGE_AFFINE_RESPONSE,
 SILLAGE_IMPLICIT_DRAG, SILLAGE_CONTACT_STATE, SILLAGE_CHECKPOINT, SILLAGE_SPIN,
 SILLAGE_REMOVES_GRAINS, SILLAGE_ADAPTS. Returns 0 or -1.

 # Safety

 `engine` is NULL or came from sillage_engine_new() and is not freed yet.
 */
int32_t sillage_engine_declare(struct sillage_engine *engine, uint32_t capability);

/*
 Say why a function of the engine fails, and return the result of this call from it. `kind` is one
 of SILLAGE_FAILURE_...; `why` names the number, the bound and the place (UTF-8, copied). From any
 thread; the first reason counts. Never returns 0.

 # Safety

 `engine` came from sillage_engine_new() and is not freed yet; `why` is NULL or ends with a zero
 byte.
 */
int32_t sillage_fail(struct sillage_engine *engine, uint32_t kind, const char *why);

/*
 Tell a number of this candidate, e.g. ("kinetic_energy", 1.2e-6), within advance(): finite, SI
 units, for people. From any thread. Returns 0 or -1.

 # Safety

 `engine` came from sillage_engine_new() and is not freed yet; `name` is NULL or ends with a zero
 byte.
 */
int32_t sillage_diagnostic(struct sillage_engine *engine, const char *name, double value);

/*
 Why the last call of this thread went wrong; "" when none did. Valid until the next call of this
 thread that goes wrong; not to be freed.
 */
const char *sillage_last_error(void);

/*
 Take the particle seat of the run that the environment names, serve the coupler until the run is
 over, and return the exit code for the process (0, or 2 to 8: protocol/README.md); -1 when the
 arguments are not usable. Blocks. To be called once in a process, from its first thread, before
 others are started.

 # Safety

 `engine` came from sillage_engine_new() and is not freed before this returns; `calls` points to
 functions that keep what this header says; `user` is passed on untouched.
 */
int32_t sillage_run_particles(struct sillage_engine *engine,
                              const struct sillage_particle_calls *calls,
                              void *user);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* SILLAGE_ENGINE_H */
