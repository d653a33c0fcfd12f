//! States for ParaView: what is in them.

use run::vtu::read::State;

use crate::background::Run;

const RADIUS: f64 = 1e-3;

/// A disk is thrown along a floor with friction, and rolls after 7 ms; with the engine of these lines.
fn roll(engine: &str) -> (State, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("roll.toml");
    let text = format!(
        "run = {{ end_time = 0.02, coupling_step = 1e-3 }}\n\
         gravity.acceleration = [0.0, -9.81]\n\
         contact = {{ friction = 0.5, tolerance = 1e-6 }}\n\
         grains = [{{ density = 2500.0, radius = {RADIUS}, velocity = [0.1, 0.0], cloud = {{ centre = \
         [2e-3, {RADIUS}], radius = {RADIUS}, count = 1, arrangement = \"sunflower\" }} }}]\n\
         particles.domain = {{ lower = [0.0, 0.0], upper = [0.06, 0.01] }}\n\
         output = {{ every = 0.01, frames = false, fields = [\"grain_spin\", \"grain_velocity\"] }}\n\
         {engine}\n"
    );
    std::fs::write(&scene, text).expect("written");
    let (code, words, _, out) = Run::start(&[scene.to_string_lossy().into_owned()]).finish();
    assert_eq!(code, Some(0), "{words}");
    let state = State::read(&out.path().join("vtu/grains_0002.vtu"));
    (state.unwrap_or_else(|error| panic!("{error}")), words)
}

#[test]
fn the_spin_of_a_disk_that_rolls_is_its_speed_over_its_radius_where_the_engine_tells_it() {
    let numbers = |state: &State, name| state.numbers(name).expect("read");
    println!("engine              v / (2/3 v0)   - spin r / v");
    for (engine, share) in [
        ("", 1e-4),
        ("engines.particles.command = [\"rapier-particles\"]", 0.02),
    ] {
        let (state, words) = roll(engine);
        let speed = numbers(&state, "grain_velocity").expect("velocities")[0];
        let spin = numbers(&state, "grain_spin [rad/s]").expect("spins")[0];
        let rolling = -spin * RADIUS / speed;
        println!(
            "{engine:19} {:12.6} {rolling:14.6}",
            speed / (0.1 * 2.0 / 3.0)
        );
        assert!((rolling - 1.0).abs() < share, "{rolling}");
        assert!(!words.contains("warning"), "{words}");
    }
    let (state, words) = roll("engines.particles.command = [\"frozen-particles\"]");
    println!("{words}");
    assert_eq!(numbers(&state, "grain_spin"), None);
    assert!(words.contains("frozen-particles does not tell grain_spin"));
}
