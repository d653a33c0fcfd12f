//! One `advance`: a candidate for the end of a step, from the accepted state, which stays.
//!
//! Read in this order: what is [`request`]ed and what a [`candidate`] is; how many sub-steps
//! ([`sub_steps`]), the contacts of one ([`sub_step`]), what is done about overlaps ([`correct`]) and
//! who hangs on a wall ([`touched`]); all of them in a row ([`motion`]); the [`engine`].

pub mod candidate;
pub mod correct;
pub mod engine;
pub mod motion;
pub mod request;
pub mod sub_step;
pub mod sub_steps;
pub mod touched;
