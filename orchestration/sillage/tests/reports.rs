//! Reports, studies and the view, on tiny runs with real processes.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use serde_json::Value;

use crate::background::{need_programs, programs, root, sillage, small_cloud};

/// Five states of a small cloud.
pub fn tiny_run(folder: &Path) {
    need_programs();
    let output = Command::new(programs().join("sillage"))
        .arg("run")
        .args(small_cloud(0.22))
        .arg("--out")
        .arg(folder)
        .output()
        .expect("started");
    let words = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{words}");
}

/// The document inside a page.
fn data_of(page: &str) -> Value {
    let start = page.find("id=\"data\">").expect("data") + "id=\"data\">".len();
    let end = start + page[start..].find("</script>").expect("its end");
    serde_json::from_str(&page[start..end]).expect("JSON")
}

/// Numbers of a packed array in single precision.
fn singles(packed: &str) -> Vec<f32> {
    let bytes = STANDARD.decode(packed).expect("base64");
    let mut planes = Vec::new();
    flate2::read::ZlibDecoder::new(bytes.as_slice())
        .read_to_end(&mut planes)
        .expect("deflated");
    let count = planes.len() / 4;
    let number = |i: usize| f32::from_le_bytes(std::array::from_fn(|p| planes[p * count + i]));
    (0..count).map(number).collect()
}

#[test]
fn a_report_is_one_file_with_the_numbers_of_the_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run");
    tiny_run(&path);
    let (code, out, words) = sillage(&["report", &path.to_string_lossy(), "--json"]);
    assert_eq!(code, Some(0), "{words}");
    let written: Value = serde_json::from_str(&out).expect("JSON");
    println!("{written}");
    assert_eq!(written["states"], 5);
    let page = std::fs::read_to_string(path.join("report.html")).expect("a page");
    for outside in ["src=\"", "http://", "https://", "@import", "url("] {
        assert!(!page.contains(outside), "the page names {outside}");
    }
    let data = data_of(&page);
    assert_eq!(data["run"]["steps"], 40);
    assert_eq!(data["steps"]["time"].as_array().map(Vec::len), Some(40));
    assert!(data["run"]["plan"]["processes"].as_array().is_some());
    let frames = data["frames"].as_array().expect("states");
    assert_eq!(frames.len(), 5);
    for name in ["speed", "pressure", "porosity", "vorticity"] {
        assert!(frames[4]["fields"][name]["data"].is_string(), "{name}");
    }
    // The centre of the grains in the page is that of steps.csv.
    let position = singles(frames[4]["position"].as_str().expect("positions"));
    let mean = position.iter().skip(1).step_by(2).map(|y| f64::from(*y));
    let centre = mean.sum::<f64>() / (position.len() / 2) as f64;
    let told = data["steps"]["centre_y"][39].as_f64().expect("a number");
    println!("centre {centre:.7} in the page, {told:.7} in steps.csv");
    assert!((centre - told).abs() < 1e-7, "{centre} for {told}");
    let memory = &data["run"]["cost"]["memory_peak"];
    assert!(
        memory["fluid"]
            .as_u64()
            .is_some_and(|bytes| bytes > 1 << 20)
    );
}

#[test]
fn a_folder_that_is_no_run_has_no_report() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().to_string_lossy();
    let (code, _, words) = sillage(&["report", &path]);
    println!("{words}");
    assert_eq!(code, Some(2));
    assert!(words.contains("run.json"), "{words}");
    std::fs::write(folder.path().join("run.json"), "{").expect("written");
    let (code, _, words) = sillage(&["report", &path]);
    println!("{words}");
    assert_eq!(code, Some(2));
}

#[test]
fn a_state_that_is_cut_off_is_refused_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run");
    tiny_run(&path);
    let state = path.join("vtu/fluid_0002.vtu");
    let text = std::fs::read_to_string(&state).expect("a state");
    let place = text.find("Name=\"pressure [Pa]\"").expect("the pressure");
    let line = place + text[place..].find('\n').expect("its values") + 1;
    std::fs::write(&state, &text[..line + 400]).expect("written");
    let (code, _, words) = sillage(&["report", &path.to_string_lossy()]);
    println!("{words}");
    assert_eq!(code, Some(2));
    assert!(words.contains("fluid_0002.vtu: pressure"), "{words}");
}

#[test]
fn a_study_runs_its_points_once_and_finds_the_order() {
    need_programs();
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("tiny.toml");
    let scene = root().join("scenes/one-grain.toml");
    let scene = std::fs::canonicalize(scene).expect("the scene");
    let text = format!(
        "title = \"tiny\"\nscene = {scene:?}\nset = [\"run.end_time=1.36453518e-3\"]\n\
         [measure]\nname = \"fall\"\ncolumn = \"fall_speed\"\n\
         [reference]\nsource = \"ODE\"\nvalue = 5.21193433e-3\n\
         [[axis]]\nname = \"step\"\npoints = [\n\
         {{ name = \"40\", size = 2.0, set = [\"run.coupling_step=3.411339e-5\"] }},\n\
         {{ name = \"80\", size = 1.0, set = [\"run.coupling_step=1.7056695e-5\"] }},\n]\n"
    );
    std::fs::write(&file, text).expect("written");
    let out = folder.path().join("out");
    let arguments = [
        "study",
        &file.to_string_lossy(),
        "--out",
        &out.to_string_lossy(),
    ];
    let (code, table, words) = sillage(&arguments);
    println!("{table}");
    assert_eq!(code, Some(0), "{words}");
    for file in [
        "study.json",
        "study.csv",
        "report.html",
        "convergence.svg",
        "convergence.png",
        "cost.svg",
        "points/40/1/run.json",
        "points/80/1/steps.csv",
    ] {
        assert!(out.join(file).exists(), "{file}");
    }
    let text = std::fs::read_to_string(out.join("study.json")).expect("results");
    let results: Value = serde_json::from_str(&text).expect("JSON");
    let order = results["points"][1]["order"].as_f64().expect("an order");
    assert!((order - 1.0).abs() < 0.1, "order {order}");
    assert_eq!(results["complete"], true);
    // A second call runs nothing, and after one point is gone only that one.
    let (code, again, words) = sillage(&arguments);
    assert_eq!((code, words.as_str()), (Some(0), ""));
    assert_eq!(again, table);
    std::fs::remove_file(out.join("points/80/1/point.json")).expect("removed");
    let (code, _, words) = sillage(&arguments);
    println!("{words}");
    assert_eq!(code, Some(0));
    assert!(
        words.contains("1 of 2 runs") && !words.contains("points/40"),
        "{words}"
    );
}

#[test]
fn a_point_that_fails_stands_in_the_table_and_a_wrong_study_is_refused() {
    need_programs();
    let folder = tempfile::tempdir().expect("a folder");
    let scene = std::fs::canonicalize(root().join("scenes/one-grain.toml")).expect("the scene");
    let study = |name: &str, measure: &str, more: &str| {
        let file = folder.path().join(name);
        let text = format!(
            "title = \"t\"\nscene = {scene:?}\nset = [\"run.end_time=2e-3\"]\n{more}\n\
             [measure]\nname = \"m\"\n{measure}\n[[axis]]\nname = \"a\"\npoints = [{{ name = \"p\" }}]\n"
        );
        std::fs::write(&file, text).expect("written");
        let out = folder.path().join(format!("{name}-out"));
        sillage(&[
            "study",
            &file.to_string_lossy(),
            "--out",
            &out.to_string_lossy(),
        ])
    };
    let (code, table, words) = study("column.toml", "column = \"fall\"", "");
    println!("{table}{words}");
    assert_eq!(code, Some(4));
    assert!(table.contains("no column fall"), "{table}");
    let (code, _, words) = study("both.toml", "column = \"a\"\njson = \"/steps\"", "");
    println!("{words}");
    assert_eq!(code, Some(2));
    let (code, _, words) = study("key.toml", "colum = \"fall_speed\"", "");
    println!("{words}");
    assert_eq!(code, Some(2));
    assert!(words.contains("colum"), "{words}");
    let (code, _, words) = sillage(&["study", "no-such-study"]);
    println!("{words}");
    assert_eq!(code, Some(2));
    assert!(words.contains("--list"), "{words}");
}

#[test]
fn a_number_is_held_against_another_point_and_one_that_cannot_be_had_loses_nothing_else() {
    need_programs();
    let folder = tempfile::tempdir().expect("a folder");
    let scene = std::fs::canonicalize(root().join("scenes/one-grain.toml")).expect("the scene");
    let study = |name: &str, against: &str| {
        let file = folder.path().join(name);
        let text = format!(
            "title = \"t\"\nscene = {scene:?}\nset = [\"run.end_time=1e-3\"]\n\
             [measure]\nname = \"fall\"\ncolumn = \"fall_speed\"\n\
             [[also]]\nmeasure = {{ name = \"height\", column = \"centre_y\" }}\n{against}\n\
             [[also]]\nmeasure = {{ name = \"nothing\", column = \"no_column\" }}\n\
             [[axis]]\nname = \"step\"\npoints = [\n\
             {{ name = \"coarse\", set = [\"run.coupling_step=1e-4\"] }},\n\
             {{ name = \"fine\", set = [\"run.coupling_step=1e-5\"] }},\n]\n"
        );
        std::fs::write(&file, text).expect("written");
        let out = folder.path().join(format!("{name}-out"));
        let (file, folder) = (file.to_string_lossy(), out.to_string_lossy());
        (sillage(&["study", &file, "--out", &folder]), out)
    };
    let ((code, table, words), out) = study("held.toml", "against = \"fine\"");
    println!("{table}{words}");
    assert_eq!(code, Some(0));
    assert!(table.contains("height (off fine)"), "{table}");
    assert!(words.contains("nothing: not known of 2 points"), "{words}");
    assert!(words.contains("no column no_column"), "{words}");
    let text = std::fs::read_to_string(out.join("study.json")).expect("results");
    let results: Value = serde_json::from_str(&text).expect("JSON");
    let [coarse, fine] = [0, 1].map(|point| &results["points"][point]);
    let height = |point: &Value| point["also"][0].as_f64().expect("a height");
    let error = coarse["also_errors"][0].as_f64().expect("an error");
    let expected = (height(coarse) / height(fine) - 1.0).abs();
    assert!(
        expected > 0.0 && (error - expected).abs() < 1e-15,
        "{error}"
    );
    assert!(fine["also_errors"][0].is_null() && fine["also"][1].is_null());
    let ((code, _, words), _) = study("wrong.toml", "against = \"finest\"");
    println!("{words}");
    assert_eq!(code, Some(2));
    assert!(
        words.contains("is no point (points: coarse, fine)"),
        "{words}"
    );
}

#[test]
fn every_built_in_study_is_valid() {
    let (code, out, words) = sillage(&["study", "--list"]);
    println!("{out}");
    assert_eq!(code, Some(0), "{words}");
    let folder = root().join("studies");
    for entry in std::fs::read_dir(folder).expect("studies").flatten() {
        let path = entry.path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let study = study::keys::read(&path).unwrap_or_else(|e| panic!("{e}"));
        // A program's arguments are its own to check.
        let Some(scene) = &study.scene else { continue };
        let scene = root().join("studies").join(scene);
        for point in study::points::points(&study) {
            scene::load(&scene, &point.settings, 1)
                .unwrap_or_else(|error| panic!("{}, {:?}: {error}", path.display(), point.names));
        }
        if let Some(reference) = &study.reference {
            let truth = study::measure::truth(reference, &root().join("studies"))
                .unwrap_or_else(|error| panic!("{error}"));
            println!("{}: {truth:?}", path.display());
        }
    }
}

/// One request by hand: status and body.
fn ask(address: &str, path: &str, host: &str) -> (u16, String) {
    let mut stream = TcpStream::connect(address).expect("connected");
    let limit = Some(Duration::from_secs(20));
    stream.set_read_timeout(limit).expect("a limit");
    write!(
        stream,
        "GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n"
    )
    .expect("sent");
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).expect("an answer");
    let answer = String::from_utf8_lossy(&answer).into_owned();
    let status = answer[9..12].parse().expect("a status");
    let body = answer.split_once("\r\n\r\n").expect("a body").1;
    (status, body.to_string())
}

#[test]
fn the_view_answers_for_its_folder_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run");
    tiny_run(&path);
    std::fs::write(folder.path().join("secret"), "secret").expect("written");
    let mut child = Command::new(programs().join("sillage"))
        .args(["view", &path.to_string_lossy()])
        .stdout(Stdio::piped())
        .spawn()
        .expect("started");
    let mut line = String::new();
    BufReader::new(child.stdout.take().expect("stdout"))
        .read_line(&mut line)
        .expect("an address");
    let address = line
        .trim_start_matches("http://")
        .split('/')
        .next()
        .expect("an address")
        .to_string();
    assert!(address.starts_with("127.0.0.1:"), "{line}");
    let (status, page) = ask(&address, "/", &address);
    assert_eq!((status, &data_of(&page)["live"]), (200, &Value::Bool(true)));
    let (status, run) = ask(&address, "/api/run", &address);
    assert_eq!(status, 200, "{run}");
    for path in ["/api/state/0", "/api/state/4"] {
        assert_eq!(ask(&address, path, &address).0, 200, "{path}");
    }
    println!("| request | status |");
    for path in [
        "/api/state/5",
        "/api/state/-1",
        "/../secret",
        "/%2e%2e/secret",
        "/run.json",
        "//etc/passwd",
        "/api/state/../../secret",
    ] {
        let (status, body) = ask(&address, path, &address);
        println!("| {path} | {status} |");
        assert_eq!(status, 404, "{path}: {body}");
        assert!(!body.contains("secret"));
    }
    assert_eq!(ask(&address, "/api/run", "evil.example:80").0, 403);
    kill(Pid::from_raw(child.id() as i32), Signal::SIGINT).expect("signalled");
    assert_eq!(child.wait().expect("ended").code(), Some(0));
}
