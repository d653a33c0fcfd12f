//! What a run costs: the same in `steps.csv`, step by step, and in the totals of `run.json`.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::background::{Run, report, root, small_cloud};
use crate::resume::kinds::FOLLOWED;

/// Columns of `steps.csv`, summed over its rows.
fn sums(text: &str) -> BTreeMap<String, f64> {
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let mut sums = BTreeMap::new();
    for line in lines {
        for (name, cell) in names.iter().zip(line.split(',')) {
            *sums.entry((*name).to_owned()).or_default() += cell.parse::<f64>().expect("a number");
        }
    }
    sums
}

#[test]
fn rows_sum_to_the_totals_and_phases_to_the_time_of_the_fluid() {
    const PHASES: [&str; 5] = ["assembly", "factor", "solve", "powers", "rest"];
    const ROUND_OFF: f64 = 1e-9;
    let mut arguments = small_cloud(0.11);
    // Tight enough for further passes.
    arguments.extend(["--set", "coupling.scheme.iterated.tolerance=1e-5"].map(str::to_owned));
    let (code, words, _, folder) = Run::start(&arguments).finish();
    assert_eq!(code, Some(0), "{words}");
    let text = |name: &str| std::fs::read_to_string(folder.path().join(name)).expect("a file");
    let sums = sums(&text("steps.csv"));
    let document: Value = serde_json::from_str(&text("run.json")).expect("JSON");
    let total = |name: &str| document["totals"][name].as_f64().expect("a number");
    let units = text("steps.units.csv");
    println!("{units}");
    let units: Vec<(&str, &str)> = units
        .lines()
        .filter_map(|row| row.split_once(','))
        .collect();
    assert_eq!(units[0], ("column", "unit"));
    let table = text("steps.csv");
    let columns = table.lines().next().expect("a header").split(',');
    assert!(columns.eq(units[1..].iter().map(|(column, _)| *column)));
    assert!(
        units.iter().all(|(_, unit)| !unit.is_empty()),
        "a column without a unit"
    );
    for known in [
        ("time", "s"),
        ("passes", "–"),
        ("fall_speed", "m/s"),
        ("cpu_fluid", "s"),
    ] {
        assert!(units.contains(&known), "{known:?}");
    }
    let same = |a: f64, b: f64| (a - b).abs() <= ROUND_OFF * a.abs().max(b.abs());
    println!("{} passes in {} steps", total("passes"), total("steps"));
    assert!(total("passes") > total("steps"), "several passes a step");

    println!("phase        steps.csv   run.json [s]");
    for phase in PHASES {
        let (rows, whole) = (
            sums[&format!("cpu_fluid_{phase}")],
            total(&format!("fluid_seconds_{phase}")),
        );
        println!("{phase:<12} {rows:.3e}   {whole:.3e}");
        assert!(rows > 0.0 && same(rows, whole));
    }
    let parts: f64 = PHASES
        .map(|phase| sums[&format!("cpu_fluid_{phase}")])
        .iter()
        .sum();
    println!("cpu_fluid    {parts:.3e}   {:.3e}", total("cpu_fluid"));
    assert!(same(parts, sums["cpu_fluid"]) && same(parts, total("cpu_fluid")));
    for (column, name) in [
        ("wall_step", "seconds_wall"),
        ("cpu_particles", "cpu_particles"),
        ("wall_fluid", "wall_fluid"),
    ] {
        assert!(same(sums[column], total(name)), "{column}");
    }
}

#[test]
fn what_meshes_change_is_told_by_the_step_after_and_summed_where_the_mesh_follows() {
    let changes = [
        ("mesh_volume", "m²"),
        ("mesh_momentum_x", "kg/s"),
        ("mesh_momentum_y", "kg/s"),
        ("mesh_energy", "J/m"),
    ];
    for follows in [false, true] {
        let mut arguments = small_cloud(0.165);
        if follows {
            let settings = FOLLOWED.iter().flat_map(|setting| ["--set", setting]);
            arguments.extend(settings.map(str::to_owned));
        }
        let (code, words, _, folder) = Run::start(&arguments).finish();
        assert_eq!(code, Some(0), "{words}");
        let text = |name: &str| std::fs::read_to_string(folder.path().join(name)).expect("a file");
        let (rows, units) = (sums(&text("steps.csv")), text("steps.units.csv"));
        let report = report(folder.path());
        let total = |name: &str| report["totals"][name].as_f64();
        for (name, unit) in changes {
            let of_rows = rows.get(name).copied();
            println!("{name:<16} {of_rows:?} {:?}", total(name));
            assert_eq!(of_rows.is_some(), follows, "{name}");
            assert_eq!(units.contains(&format!("{name},{unit}")), follows);
            match (of_rows, total(name)) {
                (Some(rows), Some(total)) => assert!((rows - total).abs() <= 1e-9 * total.abs()),
                (rows, total) => assert_eq!(rows, total),
            }
        }
        for name in ["volume", "momentum", "energy"] {
            let share = total(&format!("mesh_{name}_share_max"));
            println!("largest share of {name}: {share:?}");
            assert_eq!(
                share.is_some_and(|share| share > 0.0 && share < 0.5),
                follows
            );
        }
    }
}

#[test]
#[ignore = "a measurement, two minutes"]
fn what_the_coupler_computes_takes_a_small_part_of_a_run() {
    println!("scene              steps   CPU of the coupler, of fluid and particles [s]   share");
    for (scene, end_time) in [
        ("cloud", 0.55),
        ("cloud-uniform", 0.55),
        ("fluidised-bed", 0.5),
    ] {
        let path = root().join("scenes").join(scene).with_extension("toml");
        let mut arguments = vec![path.to_string_lossy().into_owned()];
        arguments.extend(["--set".to_owned(), format!("run.end_time={end_time}")]);
        let (code, words, _, folder) = Run::start(&arguments).finish();
        assert_eq!(code, Some(0), "{words}");
        let report = report(folder.path());
        let total = |name: &str| report["totals"][name].as_f64().expect("a number");
        // Placing, depositing and sampling (a seventh of it by a profile), drag, the fixed point, budgets, copies.
        let (coupler, engines) = (
            total("cpu_coupler"),
            total("cpu_fluid") + total("cpu_particles"),
        );
        let share = coupler / (coupler + engines);
        println!(
            "{scene:<18} {:<7} {coupler:<19.3} {engines:<31.3} {:.1} %",
            total("steps"),
            100.0 * share
        );
        assert!(share < 0.2);
    }
}
