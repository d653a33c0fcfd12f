//! The page of a run in space in a real browser, as [`browser`](crate::browser) has it.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::browser::Browser;
use crate::ring::Ring;

/// Pixels of the animation's canvas that differ from those kept before, and how many of it have any colour; it keeps
/// them.
const CHANGED: &str = "const c = document.getElementById('canvas'), gl = c.getContext('webgl2'), n = 4 * c.width * c.height; \
     const now = new Uint8Array(n); gl.readPixels(0, 0, c.width, c.height, gl.RGBA, gl.UNSIGNED_BYTE, now); \
     const old = window.kept || new Uint8Array(n); window.kept = now; let changed = 0, inked = 0; \
     for (let i = 0; i < n; i += 4) { if (now[i + 3]) inked++; if (now[i] !== old[i] || now[i + 1] !== old[i + 1] || now[i + 3] !== old[i + 3]) changed++; } \
     return [changed, inked]";

#[test]
fn the_report_of_a_run_in_space_plays_and_turns_in_a_browser_without_a_network() {
    let Some(browser) = Browser::start() else {
        eprintln!("SKIPPED: no chromedriver here; apt-get install chromium chromium-driver");
        return;
    };
    let kept = std::env::var_os("SILLAGE_PICTURES").map(PathBuf::from);
    let folder = tempfile::tempdir().expect("a folder");
    let pictures = kept.unwrap_or_else(|| folder.path().to_path_buf());
    std::fs::create_dir_all(&pictures).expect("a folder");
    let metrics = json!({ "width": 700, "height": 700, "deviceScaleFactor": 1, "mobile": false });
    browser.tell("Emulation.setDeviceMetricsOverride", metrics);
    println!("| fluid | after | pixels that changed | pixels with ink |");
    for fluid in [true, false] {
        let ring = Ring {
            box_low: [-10e-3, -10e-3, -10e-3],
            box_high: [10e-3, 10e-3, 10e-3],
            count: 2000,
            radius: 0.25e-3,
            cells: [12; 3],
            fluid,
        };
        let path = folder.path().join(format!("run-{fluid}"));
        ring.write("falling-ring", &path, 4);
        let written = show::page::write(&path, None, 100).expect("a page");
        let page = json!({ "url": format!("file://{}", written.file.display()) });
        browser.ask("url", page);
        browser.until("return document.documentElement.dataset.ready === 'yes'");
        let changed = |after: &str| {
            let pixels = browser.run(CHANGED);
            println!("| {fluid} | {after} | {} | {} |", pixels[0], pixels[1]);
            pixels[0].as_i64().expect("pixels")
        };
        assert!(changed("opening it") > 3000);
        assert_eq!(changed("nothing"), 0);
        browser.run("document.getElementById('play').click()");
        browser.until("return document.getElementById('play').textContent === 'Play' && document.getElementById('counter').textContent.includes('state 5 of 5')");
        assert!(changed("playing") > 2000);
        let drag = |x: i64, kind: &str| json!({ "type": kind, "duration": 0, "x": x, "y": 350 });
        let button = |kind: &str| json!({ "type": kind, "button": 0 });
        let drag = json!({ "actions": [{ "type": "pointer", "id": "mouse", "parameters": { "pointerType": "mouse" },
            "actions": [drag(300, "pointerMove"), button("pointerDown"), drag(380, "pointerMove"), button("pointerUp")] }] });
        browser.ask("actions", drag);
        assert!(changed("turning it by the mouse") > 3000);
        let press = |key: &str| {
            browser.run(&format!("document.getElementById('canvas').dispatchEvent(new KeyboardEvent('keydown', {{ key: '{key}' }}))"))
        };
        press("d");
        assert!(changed("turning it by a key") > 3000);
        let before = browser.run("return document.getElementById('scale').textContent");
        (0..8).for_each(|_| drop(press("+")));
        assert!(changed("zooming in") > 3000);
        let after = browser.run("return document.getElementById('scale').textContent");
        println!("scale bar {before}, zoomed in {after}");
        assert_ne!(before, after);
        press("0");
        if fluid {
            changed("showing all");
            browser.run("document.querySelector('[value=vorticity]').click()");
            assert!(changed("another field") > 2000);
        }
        let outside = browser.run("return performance.getEntriesByType('resource').filter(e => e.name.startsWith('http')).length");
        assert_eq!(outside, 0, "the page asked the network");
        let size = browser.picture(&pictures.join(format!("report-space-{fluid}.png")));
        assert!(size > 10_000, "an empty picture");
    }
}

/// A page of a ring of so many spheres in fluid.
fn ring_in_space(browser: &Browser, folder: &Path, count: usize, pixels: usize) {
    let metrics =
        json!({ "width": pixels, "height": pixels, "deviceScaleFactor": 1, "mobile": false });
    browser.tell("Emulation.setDeviceMetricsOverride", metrics);
    let ring = Ring {
        box_low: [-10e-3, -10e-3, -10e-3],
        box_high: [10e-3, 10e-3, 10e-3],
        count,
        radius: 0.25e-3 * (2000.0 / count as f64).cbrt(),
        cells: [12; 3],
        fluid: true,
    };
    let path = folder.join("run");
    ring.write("falling-ring", &path, 1);
    let written = show::page::write(&path, None, 100).expect("a page");
    let page = json!({ "url": format!("file://{}", written.file.display()) });
    browser.ask("url", page);
    browser.until("return document.documentElement.dataset.ready === 'yes'");
}

/// Fingers that go down together, each along a line, and up.
fn fingers(browser: &Browser, lines: &[[[i64; 2]; 2]]) {
    let place = |[x, y]: [i64; 2], duration: u64| json!({ "type": "pointerMove", "duration": duration, "x": x, "y": y });
    let finger = |(number, [from, to]): (usize, &[[i64; 2]; 2])| {
        let actions = [
            place(*from, 0),
            json!({ "type": "pointerDown", "button": 0 }),
            place(*to, 100),
            json!({ "type": "pointerUp", "button": 0 }),
        ];
        json!({ "type": "pointer", "id": format!("finger {number}"), "parameters": { "pointerType": "touch" }, "actions": actions })
    };
    let all: Vec<Value> = lines.iter().enumerate().map(finger).collect();
    browser.ask("actions", json!({ "actions": all }));
}

#[test]
fn one_finger_turns_the_page_of_a_run_in_space_and_two_zoom_it() {
    let Some(browser) = Browser::start() else {
        eprintln!("SKIPPED: no chromedriver here; apt-get install chromium chromium-driver");
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    ring_in_space(&browser, folder.path(), 500, 700);
    // Where the camera is: angles about the target and distance to it.
    let seen = || -> [f64; 3] {
        let found = browser.run(
            "const c = world.controls; return [c.getAzimuthalAngle(), c.getPolarAngle(), c.getDistance()]",
        );
        std::array::from_fn(|k| found[k].as_f64().expect("a number"))
    };
    let scrolled = || browser.run("return scrollY");
    let (first, before) = (seen(), scrolled());
    fingers(&browser, &[[[300, 300], [380, 340]]]);
    let turned = seen();
    fingers(
        &browser,
        &[[[320, 350], [240, 350]], [[380, 350], [460, 350]]],
    );
    let nearer = seen();
    fingers(
        &browser,
        &[[[240, 350], [320, 350]], [[460, 350], [380, 350]]],
    );
    let away = seen();
    println!("| after | around | above | away |");
    for (what, [around, above, distance]) in [
        ("opening it", first),
        ("one finger", turned),
        ("two fingers apart", nearer),
        ("two fingers together", away),
    ] {
        println!("| {what} | {around:.3} | {above:.3} | {distance:.3} |");
    }
    assert!((turned[0] - first[0]).abs() > 0.2 && (turned[1] - first[1]).abs() > 0.1);
    assert!((turned[2] / first[2] - 1.0).abs() < 1e-6);
    assert!(nearer[2] < 0.8 * turned[2] && away[2] > 1.2 * nearer[2]);
    assert_eq!(scrolled(), before, "the page went with the finger");
}

/// How long pictures of 20 000 spheres take, all of them and as many as the page draws on this machine:
/// `cargo test --release -p sillage --test commands frames_of_twenty -- --ignored --nocapture`
#[test]
#[ignore = "depends on time"]
fn frames_of_twenty_thousand_spheres_are_told() {
    let Some(browser) = Browser::start() else {
        eprintln!("SKIPPED: no chromedriver here; apt-get install chromium chromium-driver");
        return;
    };
    browser.ask("timeouts", json!({ "script": 300_000 }));
    println!("| pixels | one of | spheres | a picture [ms] | a second |");
    for pixels in [390, 700, 1280] {
        let folder = tempfile::tempdir().expect("a folder");
        ring_in_space(&browser, folder.path(), 20_000, pixels);
        let thinned = browser
            .run("return world.every")
            .as_u64()
            .expect("a number");
        for every in [1, thinned] {
            let found = browser.run(&format!(
                "world.every = {every}; placeGrains(film.shown); const gl = world.renderer.getContext(), pixel = new Uint8Array(4), times = []; \
                 for (let k = 0; k < 5; k++) {{ const begun = performance.now(); move(1, 0); \
                 gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel); times.push(performance.now() - begun); }} \
                 return [world.grains.geometry.instanceCount, times.slice(2).sort((a, b) => a - b)[1]]"
            ));
            let (drawn, wall) = (&found[0], found[1].as_f64().expect("a time"));
            println!(
                "| {pixels}² | {every} | {drawn} | {wall:.0} | {:.1} |",
                1e3 / wall
            );
        }
    }
}
