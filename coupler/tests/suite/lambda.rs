//! The policy of λ, case by case.

use coupler::coupled::defect::Defect;
use coupler::coupled::lambda::{Policy, Progress, Shown};
use coupler::state::Contact::{self, Free, Held, Touches};

const TOLERANCE: f64 = 1e-3;
const TOLD: Policy = Policy {
    free: 1.0,
    contacts_told: true,
};

/// One pass: its defect, that of each grain, who touched, who is fixed.
struct Seen {
    defect: Defect,
    contact: Vec<Contact>,
    fixed: Vec<bool>,
}

impl Seen {
    fn new(relative: f64, of_grains: &[f64], contact: &[Contact]) -> Seen {
        Seen {
            defect: Defect {
                relative,
                of_grains: of_grains.to_vec(),
                ..Defect::default()
            },
            contact: contact.to_vec(),
            fixed: vec![false; contact.len()],
        }
    }

    fn shown(&self) -> Shown<'_> {
        Shown {
            defect: &self.defect,
            contact: &self.contact,
            fixed: &self.fixed,
            tolerance: TOLERANCE,
        }
    }

    fn revise(&self, progress: &mut Progress, lambda: &mut [f64]) -> bool {
        progress.revise(&TOLD, lambda, &self.shown())
    }
}

#[test]
fn the_first_lambda_follows_from_who_is_held() {
    let contact = [Free, Touches, Held, Held, Free];
    let fixed = [false, false, false, true, true];
    let chosen = |policy: Policy, contact: &[Contact]| {
        let mut lambda = [9.0; 5];
        policy.choose(&mut lambda, &fixed, contact);
        lambda
    };
    assert_eq!(chosen(TOLD, &contact), [1.0, 1.0, 0.0, 0.0, 0.0]);
    assert_eq!(chosen(TOLD, &[]), [1.0, 1.0, 1.0, 0.0, 0.0]);
    let silent = Policy {
        contacts_told: false,
        ..TOLD
    };
    assert_eq!(chosen(silent, &contact), [1.0, 0.5, 0.0, 0.0, 0.0]);
    let slow = Policy { free: 0.7, ..TOLD };
    assert_eq!(chosen(slow, &contact), [0.7, 0.7, 0.0, 0.0, 0.0]);
}

#[test]
fn a_pass_without_a_prediction_is_the_prediction_of_the_next() {
    let seen = Seen::new(0.5, &[0.0; 2], &[Held, Free]);
    let mut progress = Progress::new(false);
    let mut lambda = [1.0, 1.0];
    assert!(seen.revise(&mut progress, &mut lambda));
    assert_eq!(lambda, [0.0, 1.0]);
    // and only once: now a held grain's λ is right or wrong
    assert!(!seen.revise(&mut progress, &mut lambda));
}

#[test]
fn after_a_first_pass_wrong_held_grains_get_a_half_and_those_let_go_get_one() {
    let (right, wrong) = (9.9 * TOLERANCE, 10.1 * TOLERANCE);
    let contact = [Held, Held, Touches, Free, Touches, Touches];
    let of_grains = [wrong, right, wrong, wrong, wrong, wrong];
    let seen = Seen::new(0.5, &of_grains, &contact);
    let mut lambda = [0.0, 0.0, 0.0, 0.0, 1.0, 0.5];
    assert!(seen.revise(&mut Progress::new(true), &mut lambda));
    assert_eq!(lambda, [0.5, 0.0, 1.0, 1.0, 1.0, 0.5]);
}

#[test]
fn held_grains_are_trouble_once_and_not_in_every_pass() {
    let mut progress = Progress::new(true);
    let mut lambda = [0.0, 1.0];
    for defect in [0.5, 0.2, 0.1, 0.05] {
        let seen = Seen::new(defect, &[0.0, 1.0], &[Held, Touches]);
        assert!(!seen.revise(&mut progress, &mut lambda));
        assert_eq!(lambda, [0.0, 1.0]);
    }
}

#[test]
fn fixed_grains_keep_zero_and_do_not_count_as_held() {
    let mut seen = Seen::new(0.5, &[1.0, 1.0], &[Held, Free]);
    seen.fixed = vec![true, false];
    let mut lambda = [0.0, 1.0];
    let mut progress = Progress::new(true);
    for _ in 0..20 {
        assert!(!seen.revise(&mut progress, &mut lambda));
        assert_eq!(lambda, [0.0, 1.0]);
    }
}

/// Passes of these defects until λ changes; `none` where it does not.
fn passes_until_raised(defects: &[f64]) -> Option<usize> {
    let mut progress = Progress::new(true);
    let mut lambda = [1.0, 0.3];
    let place = defects.iter().position(|&defect| {
        let seen = Seen::new(defect, &[0.0, 1.0], &[Touches, Touches]);
        seen.revise(&mut progress, &mut lambda)
    });
    place.map(|index| index + 1)
}

#[test]
fn patience_ends_with_the_fourth_pass_that_does_not_contract() {
    assert_eq!(passes_until_raised(&[0.1; 9]), Some(5));
    // 0.69 is progress, 0.71 is not
    let contracting: Vec<f64> = (0..9).map(|k| 0.1 * 0.69_f64.powi(k)).collect();
    assert_eq!(passes_until_raised(&contracting), None);
    assert_eq!(
        passes_until_raised(&[0.1, 0.071, 0.072, 0.08, 0.09]),
        Some(5)
    );
    assert_eq!(
        passes_until_raised(&[0.1, 0.09, 0.09, 0.069, 0.06, 0.06]),
        None
    );
    // growth by five has no patience
    assert_eq!(passes_until_raised(&[0.1, 0.49]), None);
    assert_eq!(passes_until_raised(&[0.1, 0.51]), Some(2));
}

#[test]
fn a_new_matrix_begins_to_count_anew() {
    let mut progress = Progress::new(true);
    let mut lambda = [1.0, 1.0];
    let seen = Seen::new(0.1, &[0.0, 1.0], &[Touches, Touches]);
    for _ in 0..4 {
        assert!(!seen.revise(&mut progress, &mut lambda));
    }
    progress.restart();
    for _ in 0..4 {
        assert!(!seen.revise(&mut progress, &mut lambda));
    }
    // at the first trouble only λ < ½ is suspect, at the second all that touch and are wrong
    assert!(!seen.revise(&mut progress, &mut lambda));
    assert!(seen.revise(&mut progress, &mut lambda));
    assert_eq!(lambda, [1.0, 0.5]);
    // at the third all that touch, wrong or not; then never again
    assert!(seen.revise(&mut progress, &mut lambda));
    assert_eq!(lambda, [0.5, 0.5]);
    lambda = [0.1, 0.1];
    for _ in 0..9 {
        assert!(!seen.revise(&mut progress, &mut lambda));
    }
}

#[test]
fn at_the_third_trouble_grains_that_touch_nothing_keep_one() {
    let mut progress = Progress::new(true);
    let mut lambda = [1.0, 0.2];
    let seen = Seen::new(0.1, &[1.0, 0.0], &[Free, Free]);
    let changed: Vec<bool> = (0..8)
        .map(|_| seen.revise(&mut progress, &mut lambda))
        .collect();
    assert_eq!(
        changed,
        [false, false, false, false, false, false, true, false]
    );
    assert_eq!(lambda, [1.0, 0.5]);
}
