//! What is kept of a run, in words.

use crate::scene::Scene;

/// When the state of a run is kept, and whether every engine can keep its own.
pub fn checkpoints(scene: &Scene) -> Vec<String> {
    let rule = &scene.checkpoint;
    if rule.keep == 0 {
        return vec!["nothing: the run cannot be resumed (checkpoint.keep = 0)".to_owned()];
    }
    let steps = rule
        .every_steps
        .map_or(String::new(), |steps| format!("every {steps} steps, "));
    let mut words = vec![format!(
        "its state {steps}every {} s and at its end, also an early one; {} of them stay; sillage resume goes on",
        rule.every_wall, rule.keep
    )];
    let engines = [&scene.engines.fluid, &scene.engines.particles];
    for engine in engines.into_iter().flatten() {
        words.push(format!(
            "nothing where {} lacks the capability Checkpoint, which it tells when it starts",
            engine.command.join(" ")
        ));
    }
    words
}
