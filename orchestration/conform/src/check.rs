//! A check of the suite, and what comes of it.

use protocol::message::Role;

use crate::case::Case;

/// Why a check did not pass.
#[derive(Debug, Clone, PartialEq)]
pub enum Trouble {
    /// The engine breaks the contract; how.
    Broken(String),
    /// The check does not apply; why.
    Skipped(String),
}

impl From<String> for Trouble {
    fn from(why: String) -> Trouble {
        Trouble::Broken(why)
    }
}

/// Checks that must have passed for a check to say anything.
pub type Needs = &'static [&'static str];
/// None.
pub const NOTHING: Needs = &[];
/// It has greeted.
pub const HELLO: Needs = &["hello"];
/// It is configured.
pub const READY: Needs = &["hello", "ready"];
/// It gives candidates.
pub const ANSWERS: Needs = &["hello", "ready", "advance"];
/// Two processes given the same must answer the same.
pub const REPEATABLE: Needs = &["hello", "ready", "advance", "fresh-process"];
/// Needed where states are accepted.
pub const ACCEPTS: Needs = &["hello", "ready", "advance", "fresh-process", "commit"];

/// A check of the suite.
pub struct Check {
    /// Its name on the command line.
    pub name: &'static str,
    /// What must be true.
    pub claim: &'static str,
    /// What must have passed before.
    pub needs: Needs,
    /// Only for this role.
    pub only: Option<Role>,
    /// Makes it.
    pub run: fn(&Case) -> Result<(), Trouble>,
}

impl Check {
    /// A check for both roles.
    pub const fn new(
        name: &'static str,
        claim: &'static str,
        needs: Needs,
        run: fn(&Case) -> Result<(), Trouble>,
    ) -> Check {
        let only = None;
        Check {
            name,
            claim,
            needs,
            only,
            run,
        }
    }

    /// The same for one role.
    pub const fn only(self, role: Role) -> Check {
        Check {
            only: Some(role),
            ..self
        }
    }
}
