//! One coupling step of fluid and grains. Read in this order:
//!
//! * [`step`]: S1 to S6; [`advance`]: their acceptance
//! * [`response`]: what the coupler tells the fluid about the grains, (R1)–(R4)
//! * [`lambda`]: which share of its response a grain is given, and when that changes
//! * [`defect`]: what the fluid gave minus what the grains took, (F1)–(F3)
//! * [`setting`]: what the passes of a step share
//! * [`iterate`], [`anderson`]: from pass to pass, (N1)
//! * [`carry`]: what is owed to the next step
//! * [`engines`], [`proximity`]: who computes, and who may touch where that is not told, (P1), (P2)
//! * [`comparison`]: schemes of other codes, (C1), (C2)

pub mod advance;
pub mod anderson;
pub mod carry;
pub mod comparison;
pub mod defect;
pub mod engines;
pub mod iterate;
pub mod lambda;
pub mod outcome;
pub mod proximity;
pub mod response;
pub mod setting;
pub mod step;
