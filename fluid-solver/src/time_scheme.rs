//! The time derivative.
//!
//! ```text
//!   backward Euler   D_t v = (v − vⁿ)/Δt                              a = vⁿ
//!   BDF2, r = Δt/Δt⁻ D_t v = [(1+2r)/(1+r) v − (1+r) vⁿ + r²/(1+r) vⁿ⁻¹]/Δt
//!                                                                     a = (1+r) vⁿ − r vⁿ⁻¹
//!   steady           D_t v = 0                                        a = v, iterated
//! ```

use crate::config::TimeScheme;
use crate::equations::coefficients::Carrier;
use crate::state::Flow;

/// How a known flow takes part: its weights in a and in −D_t v.
#[derive(Debug, Clone, Copy)]
struct Share {
    convects: f64,
    history: f64,
}

/// Weights of the time derivative and of the extrapolation.
#[derive(Debug, Clone, Copy)]
pub struct TimeWeights {
    /// α/Δt \[1/s\]
    pub rate: f64,
    /// How vⁿ takes part.
    now: Share,
    /// How vⁿ⁻¹ takes part, if it does.
    before: Option<Share>,
}

impl TimeWeights {
    /// For a step of length `dt` after one of length `dt_before`.
    pub fn new(scheme: TimeScheme, dt: f64, dt_before: Option<f64>) -> TimeWeights {
        let share = |convects, history| Share { convects, history };
        match (scheme, dt_before) {
            (TimeScheme::Steady, _) => TimeWeights {
                rate: 0.0,
                now: share(1.0, 0.0),
                before: None,
            },
            (TimeScheme::Bdf2, Some(dt_before)) => {
                let r = dt / dt_before;
                TimeWeights {
                    rate: (1.0 + 2.0 * r) / (1.0 + r) / dt,
                    now: share(1.0 + r, (1.0 + r) / dt),
                    before: Some(share(-r, -r * r / (1.0 + r) / dt)),
                }
            }
            (TimeScheme::Bdf2, None) | (TimeScheme::BackwardEuler, _) => TimeWeights {
                rate: 1.0 / dt,
                now: share(1.0, 1.0 / dt),
                before: None,
            },
        }
    }

    /// The known flows with their weights; none convects where convection is left out.
    pub fn carriers<'a, const D: usize>(
        &self,
        now: &'a Flow<D>,
        before: Option<&'a (Flow<D>, f64)>,
        convection: bool,
    ) -> Vec<Carrier<'a, D>> {
        let before = before.map(|(flow, _)| flow).zip(self.before);
        let shares = std::iter::once((now, self.now)).chain(before);
        shares
            .map(|(flow, share)| Carrier {
                flow,
                convects: if convection { share.convects } else { 0.0 },
                history: share.history,
            })
            .collect()
    }
}
