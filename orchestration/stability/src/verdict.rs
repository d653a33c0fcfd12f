//! Stable, or how it failed.
//!
//! | verdict | letter | when |
//! | --- | --- | --- |
//! | stable | | the run ended, and nothing of what follows |
//! | not finite | N | a value was not finite |
//! | growth | G | a speed above [`GROWTH`] times the largest of the exact solution, and growing; or grains left the mesh or filled a cell, which the exact solution never does |
//! | not converged | C | passes, contacts or the fluid's solve, also in steps of a 64th |
//! | budget broken | B | volume or third law above [`BALANCE`] |
//! | wrong limit | W | the last step is further from the closed form than the scene allows |
//! | time limit | T | an engine took longer than [`seconds`] for a step |
//! | engine failed | E | anything else |
//! | refused | R | `check` refuses the scene, with the reason |

use serde::Serialize;

use crate::scenes::Case;
use run::batch::Done;
use scene::error::exit_code;
use show::table::Table;

/// A speed this many times the largest of the exact solution is growth, when it grows.
pub const GROWTH: f64 = 3.0;
/// Largest relative defect of volume and of the third law.
pub const BALANCE: f64 = 1e-6;
/// Longest answer of an engine under the default scheme \[s\]: slow is not unstable.
pub const SECONDS: f64 = 600.0;
/// The same under the others, which may throw grains together that take long to sort.
const SECONDS_OF_OTHERS: f64 = 30.0;

/// Longest answer of an engine \[s\].
pub fn seconds(default: bool) -> f64 {
    if default { SECONDS } else { SECONDS_OF_OTHERS }
}

/// How a cell came out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// It ended where it should.
    Stable,
    /// `check` refused it.
    Refused,
    /// A value was not finite.
    NotFinite,
    /// A speed grew beyond bounds.
    Growth,
    /// Something did not converge.
    NotConverged,
    /// A balance was broken.
    BudgetBroken,
    /// It ended elsewhere than it should.
    WrongLimit,
    /// A step took too long.
    TimeLimit,
    /// A process failed.
    EngineFailed,
}

impl Verdict {
    /// All of them.
    pub const ALL: [Verdict; 9] = [
        Verdict::Stable,
        Verdict::Refused,
        Verdict::NotFinite,
        Verdict::Growth,
        Verdict::NotConverged,
        Verdict::BudgetBroken,
        Verdict::WrongLimit,
        Verdict::TimeLimit,
        Verdict::EngineFailed,
    ];

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Stable => "stable",
            Verdict::Refused => "refused",
            Verdict::NotFinite => "not finite",
            Verdict::Growth => "growth",
            Verdict::NotConverged => "not converged",
            Verdict::BudgetBroken => "budget broken",
            Verdict::WrongLimit => "wrong limit",
            Verdict::TimeLimit => "time limit",
            Verdict::EngineFailed => "engine failed",
        }
    }

    /// In a heat map.
    pub fn letter(self) -> &'static str {
        match self {
            Verdict::Stable => "",
            Verdict::Refused => "R",
            Verdict::NotFinite => "N",
            Verdict::Growth => "G",
            Verdict::NotConverged => "C",
            Verdict::BudgetBroken => "B",
            Verdict::WrongLimit => "W",
            Verdict::TimeLimit => "T",
            Verdict::EngineFailed => "E",
        }
    }

    /// May the default scheme come out so?
    pub fn allowed(self) -> bool {
        matches!(self, Verdict::Stable | Verdict::Refused)
    }
}

/// What a run showed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// Stable, or how it failed.
    pub verdict: Verdict,
    /// With its numbers, when not stable.
    pub why: Option<String>,
    /// Last value of the column of the limit.
    pub value: Option<f64>,
    /// Its relative error.
    pub error: Option<f64>,
    /// Mean over the steps.
    pub passes_mean: Option<f64>,
    /// Largest of a step.
    pub passes_max: Option<f64>,
    /// Largest of a step.
    pub sub_steps_max: Option<f64>,
    /// Steps accepted: more than asked for where some were halved.
    pub steps: usize,
}

impl Finding {
    /// Of a scene that `check` refuses.
    pub fn refused(why: String) -> Finding {
        Finding {
            verdict: Verdict::Refused,
            why: Some(why),
            value: None,
            error: None,
            passes_mean: None,
            passes_max: None,
            sub_steps_max: None,
            steps: 0,
        }
    }
}

/// Judge a run that is over by its steps.
pub fn judge(case: &Case, done: &Done, steps: &Table) -> Finding {
    let column = |name: &str| steps.column(name).unwrap_or_default();
    let largest = |name: &str| column(name).into_iter().reduce(f64::max);
    let value = column(case.limit.column).last().copied();
    let error = value.map(|value| (value - case.limit.value).abs() / case.limit.scale.abs());
    let (verdict, why) = of(case, done, &column, error);
    let passes = column("passes");
    Finding {
        verdict,
        why,
        value,
        error,
        passes_mean: (!passes.is_empty()).then(|| passes.iter().sum::<f64>() / passes.len() as f64),
        passes_max: largest("passes"),
        sub_steps_max: largest("sub_steps"),
        steps: steps.rows.len(),
    }
}

fn of(
    case: &Case,
    done: &Done,
    column: &dyn Fn(&str) -> Vec<f64>,
    error: Option<f64>,
) -> (Verdict, Option<String>) {
    let code = done.point["exit"].as_i64().unwrap_or(-1) as i32;
    let words = done.point["why"].as_str().unwrap_or("").to_string();
    let failed = match code {
        exit_code::OK => None,
        exit_code::NOT_FINITE if words.contains("finite") => Some(Verdict::NotFinite),
        exit_code::NOT_FINITE => Some(Verdict::Growth),
        exit_code::NOT_CONVERGED => Some(Verdict::NotConverged),
        exit_code::TIME_LIMIT => Some(Verdict::TimeLimit),
        _ => Some(Verdict::EngineFailed),
    };
    let speeds = |name: &str| column(name).into_iter().map(f64::abs).collect::<Vec<_>>();
    let grows = |name: &str| {
        let speeds = speeds(name);
        let last = *speeds.last()?;
        let middle = speeds[speeds.len() / 2];
        (last > GROWTH * case.speed && last >= middle).then(|| {
            format!(
                "{name} is {last:.2e} m/s, the exact solution stays below {:.2e}",
                case.speed
            )
        })
    };
    if let Some(why) = grows("fall_speed").or_else(|| grows("fluid_speed_max")) {
        let verdict = match failed {
            Some(Verdict::NotFinite) => Verdict::NotFinite,
            _ => Verdict::Growth,
        };
        let why = if words.is_empty() {
            why
        } else {
            format!("{why}; {words}")
        };
        return (verdict, Some(why));
    }
    if let Some(verdict) = failed {
        return (verdict, Some(words));
    }
    let broken = |name: &str| {
        let worst = speeds(name).into_iter().fold(0.0, f64::max);
        (worst > BALANCE).then(|| format!("{name} {worst:.1e}, allowed {BALANCE:e}"))
    };
    let third_law = || case.weighs.then(|| broken("third_law_defect")).flatten();
    if let Some(why) = broken("volume_defect").or_else(third_law) {
        return (Verdict::BudgetBroken, Some(why));
    }
    let limit = &case.limit;
    match error {
        Some(error) if error <= limit.tolerance => (Verdict::Stable, None),
        Some(error) => {
            let why = format!(
                "{} is {error:.2e} from {:.4e}, allowed {:e}",
                limit.column, limit.value, limit.tolerance
            );
            (Verdict::WrongLimit, Some(why))
        }
        None => {
            let why = format!("steps.csv has no {}", limit.column);
            (Verdict::WrongLimit, Some(why))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::Limit;
    use serde_json::{Value, json};

    fn verdict(exit: i32, why: &str, steps: &str) -> Verdict {
        let case = Case {
            text: String::new(),
            steps: 3,
            limit: Limit {
                column: "fall_speed",
                value: 1.0,
                scale: 1.0,
                tolerance: 0.05,
            },
            speed: 1.0,
            weighs: true,
            thin_slab: None,
        };
        let done = Done {
            point: json!({ "exit": exit, "why": why }),
            document: Value::Null,
        };
        let steps = format!("passes,fall_speed,volume_defect,third_law_defect\n{steps}");
        judge(&case, &done, &Table::parse(&steps).expect("a table")).verdict
    }

    #[test]
    fn each_way_to_fail_is_told_from_the_others() {
        let good = "1,0.5,0,0\n1,0.9,0,0\n1,1.01,1e-12,1e-12\n";
        assert_eq!(verdict(0, "", good), Verdict::Stable);
        assert_eq!(
            verdict(0, "", "1,0.5,0,0\n1,0.9,0,0\n1,1.1,0,0\n"),
            Verdict::WrongLimit
        );
        assert_eq!(
            verdict(0, "", "1,0.5,0,0\n1,-2,0,0\n1,9,0,0\n"),
            Verdict::Growth
        );
        assert_eq!(
            verdict(0, "", "1,0.5,0,0\n1,9,0,0\n1,1,0,0\n"),
            Verdict::Stable
        );
        assert_eq!(
            verdict(0, "", "1,0.5,0,1e-3\n1,1,0,0\n"),
            Verdict::BudgetBroken
        );
        assert_eq!(verdict(7, "grain 3 is outside", ""), Verdict::Growth);
        assert_eq!(
            verdict(7, "a position is not finite", ""),
            Verdict::NotFinite
        );
        assert_eq!(verdict(8, "60 passes", good), Verdict::NotConverged);
        assert_eq!(verdict(6, "limit", ""), Verdict::TimeLimit);
        assert_eq!(verdict(4, "fell over", ""), Verdict::EngineFailed);
        assert_eq!(verdict(0, "", ""), Verdict::WrongLimit);
    }
}
