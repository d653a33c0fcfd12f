//! What the fluid engine promises, with the tables that show it.

mod balance;
mod benchmarks;
mod bisection;
mod carried;
mod costs;
mod creeping;
mod epochs;
mod held;
mod inflow;
mod iterated_steps;
mod iterative;
mod kernel;
mod longest;
mod manufactured;
mod manufactured_in_space;
mod mean_flow;
mod open;
mod porous;
mod projection;
mod refusals;
mod serve;
mod slip_edges;
mod space;
mod space_bench;
mod support;
mod symmetry;
