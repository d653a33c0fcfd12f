//! Tests of the coupler, without an engine that solves anything.

mod anderson;
mod budget;
mod defect;
mod drag;
mod lambda;
mod mesh;
mod proximity;
mod requests;
mod response;
mod sphere;
mod spread;
mod transfer;
